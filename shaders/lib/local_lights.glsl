// The sum over the local lights, in one order in every path: ascending index, one after the other, in float32.
//   LOCAL_LIGHTS 1: all lights of the scene; 2: those of the pixel's tile (or cluster)
#include "lib/lights.glsl"
#include "lib/position.glsl"
#include "lib/steps.glsl"
#if LOCAL_SHADOWS
#include "lib/local_shadows.glsl"
#endif

// One light's share at p, `pixel` (the seed of a filter). Not-a-number and infinity stop here, so that a sum that is blended
// into a target stays finite.
vec3 light_share(uint i, vec3 p, Reflector r, uvec2 pixel)
{
    vec3 share = light_contribution(i, p, r);
#if LOCAL_SHADOWS
    // what brings nothing needs no look
    if (share.x + share.y + share.z > 0.0) {
        share *= local_visibility(i, p, r.n, pixel);
#if TRANSLUCENT_LAMPS
        share *= local_tint(i, p, r.n, pixel);
#endif
    }
#endif
    return sanitise(share);
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

#if MULTISAMPLED
layout(std430, binding = 8) readonly buffer BinMaskBlock { uint bin_mask[]; };
layout(std430, binding = 9) readonly buffer BinBlock { uvec4 bin_depth[]; };  // nearest, farthest, flags

// Which lights come next: `count` of a list or of all, or, where `words` is not 0, the bits that are set in a bin's mask.
struct Walk {
    uint at;
    uint count;
    uint first;
    bool all_lights;
    uint words;
    uint mask;
    uint left;
};

bool next_light(inout Walk w, out uint i)
{
    i = 0u;
    if (w.words == 0u) {
        if (w.at >= w.count) return false;
        i = w.all_lights ? w.at : light_list[w.first + w.at];
        ++w.at;
        return true;
    }
    while (w.left == 0u && w.at < w.words) w.left = bin_mask[w.mask + w.at++];
    if (w.left == 0u) return false;
    i = (w.at - 1u) * 32u + uint(findLSB(w.left));
    w.left &= w.left - 1u;
    return true;
}

// A point beside its tile's boxes: what its bin (4 x 4 tiles) kept by depth alone holds for it; beyond that, all lights.
void widen(inout Walk w, uvec2 tile, vec3 p)
{
    uvec2 bin = tile / 4u;
    uint index = bin.y * ((view.tiles.z + 3u) / 4u) + bin.x;
    float depth = view_depth(p);
    w.all_lights = true;
    w.count = view.counts.x;
    if (depth >= uintBitsToFloat(bin_depth[index].x) && depth <= uintBitsToFloat(bin_depth[index].y)) {
        w.words = (view.counts.x + 31u) / 32u;
        w.mask = index * w.words;
    }
}
#endif

// Which lights a tile has: from `first` on in the list, or all of the scene.
struct LightRun {
    uint first;
    uint count;
    bool all_lights;
};

LightRun light_run(uvec2 tile, int layer)
{
    uvec2 header = texelFetch(t_light_tiles, ivec3(tile, layer), 0).xy;
    // what cannot be a header of this frame means every light: slow, but right
    bool all_lights = header.y > view.counts.x || header.x > view.tiles.y || header.x + header.y > view.tiles.y;
    return LightRun(header.x, all_lights ? view.counts.x : header.y, all_lights);
}

uint light_of(LightRun run, uint k) { return run.all_lights ? k : light_list[run.first + k]; }

// `list`: 0 for what is opaque, 1 for what is blended.
vec3 add_local_lights(vec3 color, uvec2 pixel, vec3 p, Reflector r, int list)
{
    int layer = view.clusters.z > 0.5 ? cluster_slice(view_depth(p)) : list;
    uvec2 tile = pixel >> view.tiles.x;
    LightRun run = light_run(tile, layer);
#if MULTISAMPLED
    // helpers, the part of a 2x2 quad outside of the triangle, need not see what a buffer holds; they would take all lights
    if (gl_HelperInvocation) return color;
    Walk walk = Walk(0u, run.count, run.first, run.all_lights, 0u, 0u, 0u);
    if (!run.all_lights && !in_tile(tile, p, list)) widen(walk, tile, p);
    bool more = true;
    uint i;
#define ADD_LIGHT(j) if (next_light(walk, i)) color += light_share(i, p, r, pixel); else more = false;
    while (more) { REPEAT(ADD_LIGHT) }
#else
#define ADD_LIGHT(j) if (k + j < run.count) color += light_share(light_of(run, k + j), p, r, pixel);
    for (uint k = 0u; k < run.count; k += STEPS) { REPEAT(ADD_LIGHT) }
#endif
    return color;
}
#else
vec3 add_local_lights(vec3 color, uvec2 pixel, vec3 p, Reflector r, int list)
{
#define ADD_LIGHT(j) if (k + j < view.counts.x) color += light_share(k + j, p, r, pixel);
    for (uint k = 0u; k < view.counts.x; k += STEPS) { REPEAT(ADD_LIGHT) }
    return color;
}
#endif
