// The surfaces whose surroundings are looked at: what pixels show and, FLOOR, the floor that only shadows are seen of. What
// hides light stands in the picture's own depth: the floor darkens nothing.
#include "lib/surface_from_depth.glsl"
#if FLOOR
#include "lib/level_floor.glsl"
#endif

float surface_depth(ivec2 pixel)
{
#if FLOOR
    vec3 p;
    vec3 v;
    return max(depth_at(pixel), floor_at(vec2(clamp(pixel, ivec2(0), ivec2(view.size.xy) - 1)) + 0.5, ao.floor_height, p, v));
#else
    return depth_at(pixel);
#endif
}

bool is_floor(ivec2 pixel, float depth)
{
#if FLOOR
    return depth > depth_at(pixel);
#else
    return false;
#endif
}

vec3 surface_normal(ivec2 pixel, vec3 p, float depth)
{
#if FLOOR
    if (is_floor(pixel, depth)) return vec3(0.0, 1.0, 0.0);
#endif
    return facet_normal(pixel, p, depth);
}
