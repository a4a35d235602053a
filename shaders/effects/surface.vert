// Object to clip space. Positions are relative to the view's origin (a point near the camera), so that float32 is
// enough however far from the world's origin the scene lies.

layout(location = 0) in vec3 a_position;
#if HAS_NORMAL
layout(location = 1) in vec4 a_normal;
#endif
#if NORMAL_MAP
layout(location = 2) in vec4 a_tangent;
#endif
#if HAS_UV0
layout(location = 3) in vec2 a_uv0;
#endif
#if UV1
layout(location = 4) in vec2 a_uv1;
#endif
#if VERTEX_COLOR
layout(location = 5) in vec4 a_color;
#endif
#if SKINNING
layout(location = 6) in uvec4 a_joints;
layout(location = 7) in vec4 a_weights;
#if HAS_JOINTS1
layout(location = 8) in uvec4 a_joints1;
layout(location = 9) in vec4 a_weights1;
#endif
#endif
layout(location = 15) in uint a_object;

invariant gl_Position;

layout(location = 0) out vec3 v_position;
layout(location = 1) out vec3 v_normal;
layout(location = 2) flat out uint v_material;
#if NORMAL_MAP
layout(location = 3) out vec4 v_tangent;
#endif
#if HAS_UV0
layout(location = 4) out vec2 v_uv0;
#endif
#if UV1
layout(location = 5) out vec2 v_uv1;
#endif
#if VERTEX_COLOR
layout(location = 6) out vec4 v_color;
#endif

#if SKINNING
// Linear blend skinning (Magnenat-Thalmann et al. 1988): the rows of the weighted sum of the joints' matrices.
void add_joint(uint first, uint joint, float weight, inout vec4 r0, inout vec4 r1, inout vec4 r2)
{
    uint i = 3u * (first + joint);
    r0 += weight * palette[i];
    r1 += weight * palette[i + 1u];
    r2 += weight * palette[i + 2u];
}
#endif

void main()
{
    uvec4 object = objects[a_object];
#if SKINNING
    vec4 r0 = vec4(0.0);
    vec4 r1 = vec4(0.0);
    vec4 r2 = vec4(0.0);
    for (int k = 0; k < 4; ++k) add_joint(object.w, a_joints[k], a_weights[k], r0, r1, r2);
#if HAS_JOINTS1
    for (int k = 0; k < 4; ++k) add_joint(object.w, a_joints1[k], a_weights1[k], r0, r1, r2);
#endif
#else
    vec4 r0 = transforms[3u * object.x];
    vec4 r1 = transforms[3u * object.x + 1u];
    vec4 r2 = transforms[3u * object.x + 2u];
#endif
    vec4 p = vec4(a_position, 1.0);
    v_position = vec3(dot(r0, p), dot(r1, p), dot(r2, p));
    gl_Position = view.clip_from_origin * vec4(v_position, 1.0);

#if HAS_NORMAL || NORMAL_MAP
    // Normals go by the cofactor matrix: right for any scale, finite where the inverse transpose is not. The linear part
    // is brought to size 1 first: cofactors grow with the square of a node's scale, and the handedness with the cube.
    vec3 largest = max(max(abs(r0.xyz), abs(r1.xyz)), abs(r2.xyz));
    float to_unit = 1.0 / max(max(max(largest.x, largest.y), largest.z), 1e-30);
    vec3 l0 = r0.xyz * to_unit;
    vec3 l1 = r1.xyz * to_unit;
    vec3 l2 = r2.xyz * to_unit;
    vec3 c0 = cross(l1, l2);
    vec3 c1 = cross(l2, l0);
    vec3 c2 = cross(l0, l1);
    float handedness = dot(l0, c0) < 0.0 ? -1.0 : 1.0;
#endif
#if HAS_NORMAL
    vec3 n = a_normal.xyz * handedness;
    v_normal = vec3(dot(c0, n), dot(c1, n), dot(c2, n));
#else
    v_normal = vec3(0.0);  // only depth is drawn
#endif
#if NORMAL_MAP
    vec3 t = a_tangent.xyz;
    v_tangent = vec4(dot(l0, t), dot(l1, t), dot(l2, t), a_tangent.w * handedness);
#endif
#if HAS_UV0
    v_uv0 = a_uv0;
#endif
#if UV1
    v_uv1 = a_uv1;
#endif
#if VERTEX_COLOR
    v_color = a_color;
#endif
    v_material = object.y;
}
