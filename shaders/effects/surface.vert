// Object to clip space. Positions are relative to the view's origin (a point near the camera), so that float32 is
// enough however far from the world's origin the scene lies.

// effects of a project's own may not know these
#ifndef MORPH
#define MORPH 0
#endif
#ifndef DUAL_QUATERNION
#define DUAL_QUATERNION 0
#endif

layout(location = 0) in vec3 a_position;
#if HAS_NORMAL
layout(location = 1) in vec4 a_normal;
#endif
#if NORMAL_MAP || HAS_TANGENT
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
#if NORMAL_MAP || HAS_TANGENT
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
#ifdef MOTION
layout(location = 11) out vec4 v_before;  // clip space of the frame before
#endif
#ifdef NODE_SCALE
layout(location = 10) flat out float v_scale;  // of lengths in the mesh's own units
#endif

#if SKINNING
#include "lib/skinning.glsl"
#endif
#if MORPH
#include "lib/morph.glsl"
#endif
#ifdef DEBUG_VIEW
#include "lib/skin_views.glsl"
#if VIEW_OF_SKIN
layout(location = 9) out vec3 v_skin;
#endif
#endif

void main()
{
    uvec4 object = objects[a_object];
#if SKINNING
    vec4 r0, r1, r2;
    skin_rows(object.w, r0, r1, r2);
#else
    vec4 r0 = transforms[3u * object.x];
    vec4 r1 = transforms[3u * object.x + 1u];
    vec4 r2 = transforms[3u * object.x + 2u];
#endif
    vec3 position = a_position;
#if HAS_NORMAL
    vec3 normal = a_normal.xyz;
#else
    vec3 normal = vec3(0.0);
#endif
#if NORMAL_MAP || HAS_TANGENT
    vec3 tangent = a_tangent.xyz;
#else
    vec3 tangent = vec3(0.0);
#endif
#if MORPH
    morph(a_object, position, normal, tangent);
#endif
    vec4 p = vec4(position, 1.0);
    v_position = vec3(dot(r0, p), dot(r1, p), dot(r2, p));
    gl_Position = view.clip_from_origin * vec4(v_position, 1.0);
#ifdef CLIP_PLANE
    gl_ClipDistance[0] = dot(mirror_clip.plane, vec4(v_position, 1.0));
#endif
#ifdef MOTION
    // rows of the frame before lie behind those of now
#if SKINNING
    vec4 b0, b1, b2;
    skin_rows(object.w + motion.joints, b0, b1, b2);
#else
    uint row = 3u * (object.x + motion.nodes);
    vec4 b0 = transforms[row];
    vec4 b1 = transforms[row + 1u];
    vec4 b2 = transforms[row + 2u];
#endif
    vec4 before = vec4(a_position, 1.0);
#if MORPH
    vec3 no_normal = vec3(0.0);
    vec3 no_tangent = vec3(0.0);
    morph(a_object + motion.morphs, before.xyz, no_normal, no_tangent);
#endif
    v_before = motion.clip_before * vec4(dot(b0, before), dot(b1, before), dot(b2, before), 1.0);
#endif

#ifdef NODE_SCALE
    v_scale = (length(r0.xyz) + length(r1.xyz) + length(r2.xyz)) * (1.0 / 3.0);
#endif
#if HAS_NORMAL || NORMAL_MAP || HAS_TANGENT
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
    vec3 n = normal * handedness;
    v_normal = vec3(dot(c0, n), dot(c1, n), dot(c2, n));
#else
    v_normal = vec3(0.0);  // only depth is drawn
#endif
#if NORMAL_MAP || HAS_TANGENT
    vec3 t = tangent;
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
#ifdef DEBUG_VIEW
#if VIEW_OF_SKIN
    v_skin = NO_SKIN;
#if SKINNING
    int used = 0;
    vec3 mixed = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        used += int(a_weights[k] > 0.0);
        mixed += a_weights[k] * joint_color(a_joints[k]);
#if HAS_JOINTS1
        used += int(a_weights1[k] > 0.0);
        mixed += a_weights1[k] * joint_color(a_joints1[k]);
#endif
    }
    v_skin = VIEW_WEIGHTS ? mixed : count_color(used);
#endif
#endif
#endif
}
