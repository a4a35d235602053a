// Which lights can reach which part of the view: shared by the stages of engine/render/passes/light_culling.py.
// All tests may keep a light too many, never drop one that reaches a pixel. Everything is relative to the view's origin.
#include "lib/light_bounds.glsl"
#include "lib/math.glsl"
#include "lib/position.glsl"
#include "lib/tile_bounds.glsl"

const int BIN = 4;  // tiles of a bin in x and y

// A piece of the view between four planes and two depths.
struct Frustum {
    vec4 planes[4];  // inwards
    float near;
    float far;
};

// Rounding: a light is taken for larger by this part of the distances at hand.
float slack(LightBound b) { return 4e-6 * (abs(b.center.x) + abs(b.center.y) + abs(b.center.z) + b.radius); }

vec4 inward(vec4 plane) { return plane / max(length(plane.xyz), 1e-30); }

// The planes of a rectangle of pixels, from `lo` to `hi` (its edges).
void frustum_planes(vec2 lo, vec2 hi, inout Frustum f)
{
    vec2 ndc_lo = vec2(lo.x * 2.0 * view.size.z - 1.0, 1.0 - hi.y * 2.0 * view.size.w);
    vec2 ndc_hi = vec2(hi.x * 2.0 * view.size.z - 1.0, 1.0 - lo.y * 2.0 * view.size.w);
    mat4 m = transpose(view.clip_from_origin);
    f.planes[0] = inward(m[0] - ndc_lo.x * m[3]);
    f.planes[1] = inward(ndc_hi.x * m[3] - m[0]);
    f.planes[2] = inward(m[1] - ndc_lo.y * m[3]);
    f.planes[3] = inward(ndc_hi.y * m[3] - m[1]);
}

bool in_planes(Frustum f, LightBound b, float radius)
{
    vec4 c = vec4(b.center, 1.0);
    return dot(f.planes[0], c) >= -radius && dot(f.planes[1], c) >= -radius && dot(f.planes[2], c) >= -radius
        && dot(f.planes[3], c) >= -radius;
}

bool in_depth(float near, float far, float depth, float radius)
{
    return depth + radius >= near && depth - radius <= far;
}

// A spot's cone against a sphere (Wronski 2017, "Cull that cone! Improved cone/spotlight visibility tests").
bool cone_meets_sphere(LightBound b, vec3 center, float radius)
{
    vec3 to = center - b.center;
    float along = dot(to, b.axis);
    float sine = sqrt(max(1.0 - b.cos_angle * b.cos_angle, 0.0));
    float across = sqrt(max(dot(to, to) - along * along, 0.0));
    return b.cos_angle * across - sine * along <= radius && along >= -radius;
}

bool in_box(vec3 lo, vec3 hi, LightBound b, float radius)
{
    vec3 away = max(max(lo - b.center, b.center - hi), vec3(0.0));
    return dot(away, away) <= radius * radius;
}

// The even parts of [near, far] that [from, to] touches, as bits.
uint depth_bits(float near, float far, float from, float to)
{
    float scale = 32.0 / max(far - near, 1e-20);
    float first = floor((from - near) * scale - 0.01);
    float last = floor((to - near) * scale + 0.01);
    if (last < 0.0 || first > 31.0) return 0u;
    uint a = uint(clamp(first, 0.0, 31.0));
    uint z = uint(clamp(last, 0.0, 31.0));
    return (0xffffffffu << a) & (0xffffffffu >> (31u - z));
}
