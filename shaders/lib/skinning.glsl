// Where a vertex's joints take it: the rows of an affine from mesh space to the origin-relative world.
// PALETTE: three vec4 per joint. Linear: the rows of its matrix. Dual: rotation, dual part (xyzw), scale.

#if DUAL_QUATERNION
// Kavan, Collins, Zara, O'Sullivan, "Geometric Skinning with Approximate Dual Quaternion Blending" (2008), eq. 15 and
// section 4.2: scales are blended linearly and applied first; rotations are taken on the side of the first joint's.
void add_joint(uint first, uint joint, float weight, vec4 pivot, inout vec4 r0, inout vec4 r1, inout vec4 r2)
{
    uint i = 3u * (first + joint);
    vec4 q = palette[i];
    float side = dot(q, pivot) < 0.0 ? -weight : weight;
    r0 += side * q;
    r1 += side * palette[i + 1u];
    r2 += weight * palette[i + 2u];
}

// (real, dual, scale) -> the rows of translation * rotation * scale.
void finish_joints(inout vec4 r0, inout vec4 r1, inout vec4 r2)
{
    float size = inversesqrt(max(dot(r0, r0), 1e-20));  // joints that cancel leave the vertex finite
    vec4 q = r0 * size;
    vec4 d = r1 * size;
    vec3 scale = r2.xyz;
    vec3 t = 2.0 * (q.w * d.xyz - d.w * q.xyz + cross(q.xyz, d.xyz));
    float xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    float xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    float wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    r0 = vec4(vec3(1.0 - 2.0 * (yy + zz), 2.0 * (xy - wz), 2.0 * (xz + wy)) * scale, t.x);
    r1 = vec4(vec3(2.0 * (xy + wz), 1.0 - 2.0 * (xx + zz), 2.0 * (yz - wx)) * scale, t.y);
    r2 = vec4(vec3(2.0 * (xz - wy), 2.0 * (yz + wx), 1.0 - 2.0 * (xx + yy)) * scale, t.z);
}
#else
// Linear blend skinning (Magnenat-Thalmann et al. 1988): the rows of the weighted sum of the joints' matrices.
void add_joint(uint first, uint joint, float weight, vec4 pivot, inout vec4 r0, inout vec4 r1, inout vec4 r2)
{
    uint i = 3u * (first + joint);
    r0 += weight * palette[i];
    r1 += weight * palette[i + 1u];
    r2 += weight * palette[i + 2u];
}

void finish_joints(inout vec4 r0, inout vec4 r1, inout vec4 r2)
{
}
#endif

void skin_rows(uint first, out vec4 r0, out vec4 r1, out vec4 r2)
{
    r0 = vec4(0.0);
    r1 = vec4(0.0);
    r2 = vec4(0.0);
    vec4 pivot = palette[3u * (first + a_joints.x)];
    for (int k = 0; k < 4; ++k) add_joint(first, a_joints[k], a_weights[k], pivot, r0, r1, r2);
#if HAS_JOINTS1
    for (int k = 0; k < 4; ++k) add_joint(first, a_joints1[k], a_weights1[k], pivot, r0, r1, r2);
#endif
    finish_joints(r0, r1, r2);
}
