// The sum over the local lights, in one order in every path: ascending index, one after the other, in float32.
//   LOCAL_LIGHTS 1: all lights of the scene; 2: those of the pixel's tile (or cluster)
#include "lib/lights.glsl"
#include "lib/position.glsl"
#include "lib/steps.glsl"

// One light's share. Not-a-number and infinity stop here, so that a sum that is blended into a target stays finite.
vec3 light_share(uint i, vec3 p, Reflector r)
{
    return sanitise(light_contribution(i, p, r));
}

#if LOCAL_LIGHTS == 2
// A header (first, count) per tile and list; ALL_LIGHTS where the list did not fit, which then means every light.
layout(binding = 16) uniform usampler2DArray t_light_tiles;
layout(std430, binding = 5) readonly buffer LightListBlock { uint light_list[]; };
#if MULTISAMPLED
#include "lib/tile_bounds.glsl"
layout(std430, binding = 6) readonly buffer TileBlock { TileBounds tile_bounds[]; };

// A pixel that a triangle covers in part is shaded at its middle, which may lie beside the triangle: far off, where it is
// seen at a grazing angle. The lists are of what the samples show; they hold for points in that box.
bool in_tile(uvec2 tile, vec3 p, int list)
{
    TileBounds b = tile_bounds[tile.y * view.tiles.z + tile.x];
    float depth = view_depth(p);
    if (depth > b.hi_far.w && (list == 0 || (b.bits.y & 2u) == 0u)) return false;
    if (list == 0 && b.bits.x != 0u) {
        float part = (depth - b.lo_near.w) * 32.0 / max(b.hi_far.w - b.lo_near.w, 1e-20);
        if ((b.bits.x >> uint(clamp(part, 0.0, 31.0)) & 1u) == 0u) return false;
    }
    bool front = all(greaterThanEqual(p, b.lo_near.xyz)) && all(lessThanEqual(p, b.hi_far.xyz));
    bool back = all(greaterThanEqual(p, b.back_lo.xyz)) && all(lessThanEqual(p, b.back_hi.xyz));
    return list != 0 || ((front || back) && depth >= b.lo_near.w);
}
#endif

// The z-slice of a cluster at this view depth.
int cluster_slice(float depth)
{
    return int(clamp(floor(log2(max(depth, 1e-30)) * view.clusters.x + view.clusters.y), 0.0, view.clusters.z - 1.0));
}

// `list`: 0 for what is opaque, 1 for what is blended.
vec3 add_local_lights(vec3 color, uvec2 pixel, vec3 p, Reflector r, int list)
{
    int layer = view.clusters.z > 0.5 ? cluster_slice(view_depth(p)) : list;
    uvec2 header = texelFetch(t_light_tiles, ivec3(pixel >> view.tiles.x, layer), 0).xy;
    // what cannot be a header of this frame means every light: slow, but right
    bool all_lights = header.y > view.counts.x || header.x > view.tiles.y || header.x + header.y > view.tiles.y;
#if MULTISAMPLED
    all_lights = all_lights || !in_tile(pixel >> view.tiles.x, p, list);
#endif
    uint count = all_lights ? view.counts.x : header.y;
#define ADD_LIGHT(j) if (k + j < count) \
        color += light_share(all_lights ? k + j : light_list[header.x + k + j], p, r);
    for (uint k = 0u; k < count; k += STEPS) { REPEAT(ADD_LIGHT) }
    return color;
}
#else
vec3 add_local_lights(vec3 color, uvec2 pixel, vec3 p, Reflector r, int list)
{
#define ADD_LIGHT(j) if (k + j < view.counts.x) color += light_share(k + j, p, r);
    for (uint k = 0u; k < view.counts.x; k += STEPS) { REPEAT(ADD_LIGHT) }
    return color;
}
#endif
