// A light's volume without vertex buffers: a solid of revolution about its axis, RINGS x SEGMENTS quads, that encloses
// the sphere or, for a narrow spot, the sector of it. It is convex, so that its back faces cover each pixel once.
#include "lib/light_bounds.glsl"

flat layout(location = 0) out uint v_light;

const float TURN = 6.28318530717959;

// (along the axis, away from it) of a ring: a polygon about the half disc, or about the sector of half angle `angle`.
vec2 ring(int i, float angle, bool sector)
{
    float share = float(i) / float(RINGS);
    if (!sector) {
        float t = 0.5 * TURN * share;
        return vec2(cos(t), sin(t)) / cos(0.25 * TURN / float(RINGS));
    }
    // two chords for the cap, the apex a bit behind the light
    if (i <= 2) {
        float t = angle * 0.5 * float(i);
        return vec2(cos(t), sin(t)) / cos(0.25 * angle);
    }
    vec2 rim = vec2(cos(angle), sin(angle)) / cos(0.25 * angle);
    return mix(rim, vec2(-0.01, 0.0), float(i - 2) / float(RINGS - 2));
}

void main()
{
    v_light = uint(gl_InstanceID);
    LightBound b = light_bound(v_light);
    if (!(b.radius < ENDLESS)) {
        // everywhere: one triangle over the whole picture, at the far plane, turned like a back face
        vec2 corner = vec2((gl_VertexID & 2) != 0 ? 3.0 : -1.0, (gl_VertexID & 1) != 0 ? 3.0 : -1.0);
        gl_Position = gl_VertexID < 3 ? vec4(corner, 0.0, 1.0) : vec4(2.0, 2.0, 2.0, 1.0);
        return;
    }
    int quad = gl_VertexID / 6;
    int corner = gl_VertexID % 6;  // 00 10 11, 00 11 01 (ring, segment): outwards counter-clockwise
    int i = quad / SEGMENTS + (corner == 1 || corner == 2 || corner == 4 ? 1 : 0);
    int s = quad % SEGMENTS + (corner == 2 || corner >= 4 ? 1 : 0);
    bool sector = b.cos_angle > 0.5;
    vec3 axis = b.cos_angle > -1.0 ? b.axis : vec3(0.0, 0.0, 1.0);
    // Duff et al. 2017, "Building an Orthonormal Basis, Revisited", JCGT 6(1), listing 3
    float sign_z = axis.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (sign_z + axis.z);
    float c = axis.x * axis.y * a;
    vec3 u = vec3(1.0 + sign_z * axis.x * axis.x * a, sign_z * c, -sign_z * axis.x);
    vec3 v = vec3(c, sign_z + axis.y * axis.y * a, -axis.y);
    float turn = TURN * float(s == SEGMENTS ? 0 : s) / float(SEGMENTS);  // the last meets the first bit by bit
    vec2 at = ring(i, acos(clamp(b.cos_angle, -1.0, 1.0)), sector);
    at.y *= i == 0 || i == RINGS ? 0.0 : 1.0 / cos(0.5 * TURN / float(SEGMENTS));
    vec3 p = b.center + b.radius * (at.x * axis + at.y * (cos(turn) * u + sin(turn) * v));
    gl_Position = view.clip_from_origin * vec4(p, 1.0);
}
