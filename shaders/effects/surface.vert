// Object to clip space. Positions are relative to the view's origin (a point near the camera), so that float32 is
// enough however far from the world's origin the scene lies.

layout(location = 0) in vec3 a_position;
layout(location = 1) in vec4 a_normal;
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

void main()
{
    uvec4 object = objects[a_object];
    vec4 r0 = transforms[3u * object.x];
    vec4 r1 = transforms[3u * object.x + 1u];
    vec4 r2 = transforms[3u * object.x + 2u];
    vec4 p = vec4(a_position, 1.0);
    v_position = vec3(dot(r0, p), dot(r1, p), dot(r2, p));
    gl_Position = view.clip_from_origin * vec4(v_position, 1.0);

    // Normals go by the cofactor matrix: right for any scale, finite where the inverse transpose is not.
    vec3 c0 = cross(r1.xyz, r2.xyz);
    vec3 c1 = cross(r2.xyz, r0.xyz);
    vec3 c2 = cross(r0.xyz, r1.xyz);
    float handedness = dot(r0.xyz, c0) < 0.0 ? -1.0 : 1.0;
    vec3 n = a_normal.xyz * handedness;
    v_normal = vec3(dot(c0, n), dot(c1, n), dot(c2, n));
#if NORMAL_MAP
    vec3 t = a_tangent.xyz;
    v_tangent = vec4(dot(r0.xyz, t), dot(r1.xyz, t), dot(r2.xyz, t), a_tangent.w * handedness);
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
