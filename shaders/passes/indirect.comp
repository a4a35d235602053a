// Light that arrives from other surfaces at each texel of a layer, cosine-weighted, over pi; and which part of the
// hemisphere is left to the environment.
//
// METHOD 0  slices (lib/slices.glsl): places along a slice cover the sectors between their front and their back; what newly
//           covers a sector is what is seen in it.
// METHOD 1  spiral: Mara et al. 2016, "Deep G-Buffers for Stable Global Illumination Approximation", sect. 4.2: the mean
//           over places that are in front; nothing hides anything. 2 / M, not 2 pi / M: their B is over pi here.
#include "lib/gather_read.glsl"
#if METHOD == 0
#include "lib/slices.glsl"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1, rgba16f) uniform writeonly image2D i_gathered;

const float IN_PLANE = 0.02;  // sine above the tangent plane that rounding may make

// Of what is gathered: light by weight; weights of what is known to be there, to be open, and of what nobody saw.
struct Gathered {
    vec3 light;
    float known;
    float open_sky;
    float unseen;
};

int level_of(float spacing)
{
    return clamp(int(floor(log2(max(spacing, 1.0)))) - FINER, 0, LEVELS - 1);
}

#if METHOD == 0
// The place before, of the same layer: its sector, and how far from the camera it is.
struct Step {
    float sector;
    float depth;
};

// What one place covers: from its front to its back, as thick as the layers are apart; and what lies between it and the
// place before where both may be of one surface, which seen at a steep angle goes back FALL times as far as aside (texels).
void cover(Slice s, float side, vec3 p, vec3 n, ivec2 at, ivec2 whole, int level, int layer, float depth, float aside,
           inout Step last, inout uint covered, inout Gathered g)
{
    if (!(depth > 0.0)) {
        last.depth = -1.0;
        return;
    }
    vec3 place = layer_place(whole, depth);
    vec3 q = place - p;
    float d2 = dot(q, q);
    float far = view_depth(place);
    float front = sector_of(s, place_in(s, q, n, side));
    bool joined = last.depth > 0.0 && abs(far - last.depth) < gi.separation + FALL * aside * gi.scale.y / pixels_per_metre(far);
    float before = last.sector;
    last = Step(front, far);
    if (!(d2 < gi.radius * gi.radius) || d2 < 1e-30) return;
    if (dot(q, n) < IN_PLANE * sqrt(d2)) return;
    vec3 behind = q - safe_normalize(view_vector(place)) * gi.separation;
    uint bits = bits_between(s, front, sector_of(s, place_in(s, behind, n, side)));
    if (joined) bits |= bits_between(s, before, front);
    bits &= ~covered;
    if (bits == 0u) return;
    covered |= bits;
    float weight = sector_weight(s) * float(bitCount(bits));
    if (dot(side_of(at, level, layer), q) < 0.0) {
        g.light += weight * calm_light(whole, level, layer, depth, COARSER);
        g.known += weight;
    } else {
        g.unseen += weight * UNSEEN;  // its other side: dark, or as what is seen
    }
}

void gather_side(Slice s, ivec2 own, float own_depth, vec3 p, vec3 n, vec2 towards, float side, float reach, float shift,
                 inout uint covered, inout Gathered g, out bool left_picture)
{
    // no farther than the border: places are not wasted
    vec2 room = mix(vec2(own), gi.size.xy - 1.0 - vec2(own), greaterThan(towards, vec2(0.0))) / max(abs(towards), vec2(1e-6));
    float border = max(min(room.x, room.y), 0.0);
    left_picture = border < reach;
    reach = min(reach, border);
    float end = side > 0.0 ? 32.0 : 0.0;
    Step last0 = Step(end, own_depth);
    Step last1 = Step(end, -1.0);
    float before = 0.0;
    for (int j = 0; j < STEPS; ++j) {
        float u = (float(j) + shift) / float(STEPS);
        float far = max(reach * u * u, 1.0);
        ivec2 texel = own + ivec2(round(far * towards));
        if (!inside_layers(texel)) return;
        int level = level_of(reach * 2.0 * u / float(STEPS));
        ivec2 whole;
        ivec2 at = texel_of(texel, level, whole);
        if (whole == own) continue;
        float aside = far - before;
        before = far;
        vec2 depths = texelFetch(t_depths, at, level).xy;
        cover(s, side, p, n, at, whole, level, 0, depths.x, aside, last0, covered, g);
#if LAYERS > 1
        cover(s, side, p, n, at, whole, level, 1, depths.y, aside, last1, covered, g);
#endif
    }
}

Gathered gather(ivec2 cell, ivec2 own, vec3 p, vec3 n, vec3 v, float reach)
{
    Gathered g = Gathered(vec3(0.0), 0.0, 0.0, 0.0);
    float turn = fract((float(pattern(cell)) + 0.5) / 16.0 + gi.turn);
    float shift = fract((float(pattern(cell.yx + ivec2(1, 2))) + 0.5) / 16.0 + gi.turn * 7.0);
    vec3 right = safe_normalize(view.place_x.xyz);
    vec3 first = safe_normalize(right - dot(right, v) * v);
    vec3 second = cross(v, first);
    for (int i = 0; i < DIRECTIONS; ++i) {
        // even about v, which evenly in the picture would not be
        float angle = (float(i) + turn) * PI / float(DIRECTIONS);
        Slice s = slice_at(v, n, first, second, angle, fract(shift + float(i) * 0.618034));
        vec2 towards = picture_direction(p, s.side);
        uint covered = 0u;
        bool left[2];
        gather_side(s, own, view_depth(p), p, n, towards, 1.0, reach, shift, covered, g, left[0]);
        gather_side(s, own, view_depth(p), p, n, -towards, -1.0, reach, shift, covered, g, left[1]);
        float each = sector_weight(s);
        // sectors on the far side of v belong to the second walk
        int middle = int(floor(32.0 * sat(-s.low / max(s.high - s.low, 1e-6)) + s.jitter));
        uint free_bits = ~covered;
        float ahead = each * float(bitCount(free_bits & ~bits_below(middle)));
        float behind = each * float(bitCount(free_bits & bits_below(middle)));
        if (left[0]) g.unseen += ahead; else g.open_sky += ahead;
        if (left[1]) g.unseen += behind; else g.open_sky += behind;
    }
    float part = 1.0 / float(DIRECTIONS);
    g.light *= part;
    g.known *= part;
    g.open_sky *= part;
    g.unseen *= part;
    return g;
}
#else
Gathered gather(ivec2 cell, ivec2 own, vec3 p, vec3 n, vec3 v, float reach)
{
    const float turns = 19.0;
    Gathered g = Gathered(vec3(0.0), 0.0, 0.0, 0.0);
    float turn = fract((float(pattern(cell)) + 0.5) / 16.0 + gi.turn);
    float shift = fract((float(pattern(cell.yx + ivec2(1, 2))) + 0.5) / 16.0 + gi.turn * 7.0);
    float used = 0.0;
    for (int i = 0; i < STEPS; ++i) {
        float u = (float(i) + shift) / float(STEPS);
        float angle = (u * turns + turn) * 2.0 * PI;
        ivec2 texel = own + ivec2(round(max(u * reach, 1.0) * vec2(cos(angle), sin(angle))));
        if (!inside_layers(texel)) continue;
        int level = level_of(reach / float(STEPS) * 2.0);
        ivec2 whole;
        ivec2 at = texel_of(texel, level, whole);
        vec2 depths = texelFetch(t_depths, at, level).xy;
        float best = 0.0;
        float cosine = 0.0;
        vec3 light = vec3(0.0);
        for (int layer = 0; layer < LAYERS; ++layer) {
            float depth = layer == 0 ? depths.x : depths.y;
            if (!(depth > 0.0)) continue;
            vec3 q = layer_place(whole, depth) - p;
            float d2 = dot(q, q);
            if (!(d2 < gi.radius * gi.radius) || d2 < 1e-30) continue;
            vec3 w = q * inversesqrt(d2);
            float n_dot_w = dot(n, w);
            if (!(n_dot_w > 0.0) || !(dot(side_of(at, level, layer), -w) > 0.01)) continue;
            vec3 sent = sent_by(at, level, layer);
            float rank = n_dot_w * (dot(sent, sent) + 1.0);
            if (rank > best) {
                best = rank;
                cosine = n_dot_w;
                light = sent;
            }
        }
        if (best > 0.0) {
            used += 1.0;
            g.light += 2.0 * cosine * light;
        }
    }
    // the mean over what was found holds for the part that was
    g.known = used / float(STEPS);
    g.light *= used > 0.0 ? g.known / used : 0.0;
    g.open_sky = 1.0 - g.known;
    return g;
}
#endif

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(i_gathered)))) return;
    ivec2 own = whole_texel(texel, OWN_LEVEL);
    vec4 result = vec4(0.0, 0.0, 0.0, 1.0);
    vec2 depths = texelFetch(t_depths, own, 0).xy;
    float depth = OF_LAYER == 0 ? depths.x : depths.y;
    if (depth > 0.0 && gi.strength > 0.0) {
        vec3 p = layer_place(own, depth);
        vec3 v = safe_normalize(view_vector(p));
        vec3 n = shape_normal(texelFetch(t_shape, own, 0).xy, v);
        float reach = min(gi.radius * pixels_per_metre(view_depth(p)) / gi.scale.y, gi.size.x + gi.size.y);
        if (reach > 1.0) {
            Gathered g = gather(texel, own, p, n, v, reach);
#if UNSEEN
            // what nobody saw is taken to be as what was, where that is more than a glimpse
            float more = g.known + g.open_sky > 0.05 ? g.unseen / (g.known + g.open_sky) : 0.0;
            result = vec4(g.light * (1.0 + more), more > 0.0 ? g.open_sky * (1.0 + more) : g.open_sky + g.unseen);
#else
            result = vec4(g.light, g.open_sky + g.unseen);
#endif
            if (gi.confidence > 0.5) result = vec4(vec3(g.known + g.open_sky), 1.0);
        }
    }
    imageStore(i_gathered, texel, vec4(sanitise(result.rgb), result.a > 0.0 ? min(result.a, 2.0) : 0.0));
}
