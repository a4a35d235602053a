// The list of lights of each tile, in ascending order.
//   WRITES 0: how long it is, into the header; 1: take room for it and write it; where there is none, the header says that
//   all lights are meant
//   z of the dispatch: which list. 0: what is solid; 1: what is blended; with clusters: the slice
#include "lib/light_culling.glsl"
#include "lib/light_groups.glsl"
#include "lib/steps.glsl"

layout(local_size_x = 4, local_size_y = 4) in;
layout(std430, binding = 1) readonly buffer TileBlock { TileBounds tile_bounds[]; };
layout(std430, binding = 3) readonly buffer BinMaskBlock { uint bin_mask[]; };
layout(std430, binding = 6) readonly buffer BinPartBlock { uint bin_parts[]; };
layout(std430, binding = 5) writeonly buffer LightListBlock { uint light_list[]; };
// entries taken, lists without room, entries wanted / 256 and what that leaves of each list, lights tried
layout(std430, binding = 7) buffer CounterBlock { uint counters[]; };
layout(binding = 0, rg32ui) uniform uimage2DArray i_light_tiles;

const uint ALL_LIGHTS = 0xffffffffu;

struct Target {
    Frustum frustum;
    vec3 lo[2];       // boxes about what the list is for
    vec3 hi[2];
    bool boxed;       // whether there are any
    uint bins;
    vec3 cone_axis;   // TEST 2: of the cone from the eye about the tile
    float cone_cos;
    float cone_sin;
};

// A light and one box; a spot against the sphere about it.
bool meets_box(vec3 lo, vec3 hi, LightBound b, float radius)
{
    if (lo.x > hi.x) return false;  // empty
#if TEST == 1
    if (b.radius < ENDLESS && !in_box(lo, hi, b, radius)) return false;
#endif
    return !(b.cos_angle > -1.0)
        || cone_meets_sphere(b, 0.5 * (lo + hi), 0.5001 * length(hi - lo) + slack(b));
}

bool keeps(Target t, LightBound b)
{
    float radius = b.radius + slack(b);
    bool bounded = b.radius < ENDLESS;
    if (bounded) {
        float depth = view_depth(b.center);
        if (!in_depth(t.frustum.near, t.frustum.far, depth, radius)) return false;
#if TEST == 2
        // sphere against the cone from the eye
        vec3 to = b.center - view.camera.xyz;
        float along = dot(to, t.cone_axis);
        float across = sqrt(max(dot(to, to) - along * along, 0.0));
        if (view.camera.w > 0.5 ? t.cone_cos * across - t.cone_sin * along > radius
                                : !in_planes(t.frustum, b, radius)) return false;
#else
        if (!in_planes(t.frustum, b, radius)) return false;
#endif
#if DEPTH_BINS
        if (t.boxed && (t.bins & depth_bits(t.frustum.near, t.frustum.far, depth - radius, depth + radius)) == 0u)
            return false;
#endif
    }
    return !t.boxed || meets_box(t.lo[0], t.hi[0], b, radius) || meets_box(t.lo[1], t.hi[1], b, radius);
}

// Whether the target keeps any light of this word of the mask.
bool group_in(Target t, uint word)
{
    return group_meets(word, t.frustum)
        && (!t.boxed || group_meets_box(word, t.lo[0], t.hi[0]) || group_meets_box(word, t.lo[1], t.hi[1]));
}

// The point at a view depth on the ray through a place of the picture (pixels).
vec3 at_depth(vec2 pixel, float depth)
{
    vec2 ndc = vec2(pixel.x * 2.0 * view.size.z - 1.0, 1.0 - pixel.y * 2.0 * view.size.w);
    vec3 aside = ndc.x * view.place_x.xyz + ndc.y * view.place_y.xyz;
    if (view.camera.w > 0.5) return view.place_base.xyz + (view.place_z.xyz + aside) * depth;
    return view.place_base.xyz + aside - view.camera.xyz * (depth - view_depth(view.place_base.xyz));
}

// The depth at which a slice begins.
float slice_start(int s) { return s <= 0 ? 0.0 : exp2((float(s) - view.clusters.y) / view.clusters.x); }

void main()
{
    uvec2 tile = gl_GlobalInvocationID.xy;
    if (tile.x >= view.tiles.z || tile.y >= view.tiles.w) return;
    int list = int(gl_WorkGroupID.z);
    uint bin_index = gl_WorkGroupID.y * culling.bin_columns + gl_WorkGroupID.x;
    TileBounds bounds = tile_bounds[tile.y * view.tiles.z + tile.x];
    bool solid = (bounds.bits.y & 1u) != 0u;
    bool sky = (bounds.bits.y & 2u) != 0u;

    Target t;
    vec2 first = vec2(tile << view.tiles.x);
    vec2 end = min(first + float(1 << view.tiles.x), view.size.xy);
    frustum_planes(first, end, t.frustum);
    t.lo[0] = bounds.lo_near.xyz;
    t.hi[0] = bounds.hi_far.xyz;
    t.lo[1] = bounds.back_lo.xyz;
    t.hi[1] = bounds.back_hi.xyz;
    t.bins = bounds.bits.x;
    t.boxed = true;
    t.frustum.near = bounds.lo_near.w;
    t.frustum.far = bounds.hi_far.w;
    bool wanted = solid;
#if CLUSTERS
    // every slice that may show something: up to the farthest pixel, or all where the blended lie before the sky
    bool blended = culling.blended != 0u;
    float from = slice_start(list) * 0.9999;
    float to = list + 1 == int(view.clusters.z) ? 3e38 : slice_start(list + 1) * 1.0001;
    float far = blended && sky ? 3e38 : bounds.hi_far.w;
    wanted = (solid || blended) && from <= far && (blended || to >= bounds.lo_near.w);
    t.frustum.near = from;
    t.frustum.far = to;
    vec3 lo = vec3(3e38);
    vec3 hi = vec3(-3e38);
    for (int k = 0; k < 8; ++k) {
        vec3 corner = at_depth(vec2((k & 1) != 0 ? end.x : first.x, (k & 2) != 0 ? end.y : first.y), (k & 4) != 0 ? to : from);
        lo = min(lo, corner);
        hi = max(hi, corner);
    }
    bool closed = list + 1 < int(view.clusters.z);
    float pad = 1e-4 * length(max(abs(lo), abs(hi)));
    t.boxed = closed || !blended;
    if (blended) {  // the tile's box is that of what is solid
        t.lo[0] = lo - pad;
        t.hi[0] = hi + pad;
    } else if (closed) {
        t.lo[0] = max(t.lo[0], lo - pad);
        t.hi[0] = min(t.hi[0], hi + pad);
        wanted = wanted && all(lessThanEqual(t.lo[0], t.hi[0]));
    }
    t.lo[1] = vec3(3e38);
    t.hi[1] = vec3(-3e38);
#else
    if (list == 1) {
        wanted = solid || sky;
        t.frustum.near = 0.0;
        t.frustum.far = sky ? 3e38 : bounds.hi_far.w;
        t.boxed = false;
    }
#endif
#if TEST == 2
    vec3 corner[4];
    t.cone_axis = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        vec2 at = vec2((k & 1) != 0 ? end.x : first.x, (k & 2) != 0 ? end.y : first.y);
        corner[k] = safe_normalize(position_from_depth(at, 1.0) - view.camera.xyz);
        t.cone_axis += corner[k];
    }
    t.cone_axis = safe_normalize(t.cone_axis);
    t.cone_cos = 1.0;
    for (int k = 0; k < 4; ++k) t.cone_cos = min(t.cone_cos, dot(t.cone_axis, corner[k]));
    t.cone_cos = clamp(t.cone_cos - 1e-5, 0.0, 1.0);
    t.cone_sin = sqrt(1.0 - t.cone_cos * t.cone_cos);
#endif

#if WRITES
    uint count = imageLoad(i_light_tiles, ivec3(tile, list)).y;
    if (count == 0u) return;
    // taken only if it fits: the counter never passes the room, so it cannot wrap round
    uint old = counters[0];
    bool taken = false;
    for (;;) {
        if (old + count > view.tiles.y) break;
        uint seen = atomicCompSwap(counters[0], old, old + count);
        if (seen == old) {
            taken = true;
            break;
        }
        old = seen;
    }
    imageStore(i_light_tiles, ivec3(tile, list), uvec4(taken ? uvec2(old, count) : uvec2(0u, ALL_LIGHTS), 0u, 0u));
    if (!taken) {
        atomicAdd(counters[1], 1u);
        return;
    }
    uint at = old;
#define FOUND if (at < old + count) light_list[at++] = i;
#else
    uint count = 0u;
    uint tried = 0u;
#define FOUND ++count;
#endif
    for (uint part = 0u; part < culling.parts && wanted; ++part) {
        uint words = bin_parts[bin_index * culling.parts + part];
        while (words != 0u) {
            uint w = part * 32u + uint(findLSB(words));
            words &= words - 1u;
            uint left = group_in(t, w) ? bin_mask[bin_index * culling.words + w] : 0u;
#if !WRITES
            tried += uint(bitCount(left));
#endif
#define TRY(j) if (left != 0u) { \
                uint i = w * 32u + uint(findLSB(left)); \
                left &= left - 1u; \
                if (keeps(t, light_bound(i))) { FOUND } \
            }
            while (left != 0u) { REPEAT(TRY) }
        }
    }
#if !WRITES
    imageStore(i_light_tiles, ivec3(tile, list), uvec4(0u, count, 0u, 0u));
    if (count > 0u) {
        atomicAdd(counters[2], count >> 8u);
        atomicAdd(counters[3], count & 255u);
    }
    if (tried > 0u) atomicAdd(counters[4], tried);
#endif
}
