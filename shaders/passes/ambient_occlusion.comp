// How much of the surroundings each pixel sees, cosine-weighted, from depth alone. What hides them counts less with its
// distance d: by 1 - (d / radius)^2.
//
// METHOD 0  Alchemy: McGuire, Osman, Bukowski, Hennessy 2011, "The Alchemy Screen-Space Ambient Obscurance Algorithm",
//           eq. 10, with our fall-off in place of 1/d, on a spiral (McGuire, Mara, Luebke 2012, eq. 7; Vogel 1979)
// METHOD 1  horizons: Bavoil, Sainz, Dimitrov 2008, "Image-Space Horizon-Based Ambient Occlusion", eq. 3; weighted by
//           the cosine as light is, so with the squares of the sines, and measured from the tangent plane
// METHOD 2  ground truth: the hemisphere in slices (lib/slices.glsl) weighted as in Jimenez, Wu, Pesce, Jarabo 2016,
//           "Practical Realtime Strategies for Accurate Indirect Occlusion", eq. 7. A place hides the sectors between its
//           front and its back, and not all below it: else a bar half a metre before a wall leaves 0.65 of the light
//           beside it in the place of 0.93
#include "lib/ambient_surface.glsl"
#include "lib/ambient_texels.glsl"
#include "lib/pixel_pattern.glsl"
#include "lib/slices.glsl"
#if LEVELS > 0
#include "lib/half_depths.glsl"
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1, FORMAT) uniform writeonly image2D i_visibility;
#if LEVELS > 0
layout(binding = 17) uniform sampler2D t_depths;

// log2 of the pixels from which on the next smaller copy of depth is taken: places lie that far apart, or more
const int FINE = 3;
#endif

float falloff(float d2)
{
    return sat(1.0 - d2 * ao.per_radius_squared);
}

// The sine of an elevation over the tangent plane; what rises by no more than rounding does is in the plane.
float above_plane(float sine)
{
    return sine * smoothstep(ao.bias, 2.0 * ao.bias, sine);
}

// From p to what the pixel shows; `seen` false where that says nothing.
vec3 blocker(ivec2 pixel, ivec2 own, vec3 p, out bool seen)
{
    seen = false;
    if (pixel == own || !inside_picture(pixel)) return vec3(0.0);
#if LEVELS > 0
    vec2 apart = vec2(pixel - own);
    int level = min(int(floor(0.5 * log2(dot(apart, apart)))) - FINE, LEVELS);
    float depth;
    if (level > 0) {
        ivec2 texel = min(pixel >> level, last_texel(textureSize(t_depths, 0), level - 1));
        depth = texelFetch(t_depths, texel, level - 1).r;
        pixel = whole_texel(texel, level);
    } else {
        depth = depth_at(pixel);
    }
#else
    float depth = depth_at(pixel);
#endif
    if (!(depth > 0.0)) return vec3(0.0);
    seen = true;
    return place_at(pixel, depth) - p;
}

// The squared distance to the nearest of what a pixel hides from us at d from p: bodies are taken to be that thick, so
// that a ball hides the ground that it stands on although only its front is seen.
float nearest(vec3 p, vec3 d)
{
    vec3 away = -safe_normalize(view_vector(p + d));
    vec3 e = d + away * clamp(-dot(d, away), 0.0, ao.thickness);
    return max(dot(e, e), 1e-30);
}

float alchemy(ivec2 own, vec3 p, vec3 n, float reach, float turn)
{
    float sum = 0.0;
    for (int i = 0; i < STEPS; ++i) {
        float u = (float(i) + 0.5) / float(STEPS);
        float angle = float(i) * 2.39996323 + turn * 2.0 * PI;
        bool seen;
        vec3 d = blocker(own + ivec2(round(reach * sqrt(u) * vec2(cos(angle), sin(angle)))), own, p, seen);
        if (!seen) continue;
        float d2 = max(dot(d, d), 1e-30);
        sum += falloff(d2) * above_plane(dot(d, n) * inversesqrt(d2));
    }
    return 1.0 - 2.0 * sum / float(STEPS);
}

// Of one side of a slice: the sum of (sin^2 h - sin^2 h before) * fall-off, h rising from the tangent plane.
float side_of_horizon(ivec2 own, vec3 p, vec3 n, vec2 towards, float reach, float shift)
{
    float highest = 0.0;
    float sum = 0.0;
    for (int j = 0; j < STEPS; ++j) {
        float u = (float(j) + shift) / float(STEPS);
        bool seen;
        vec3 d = blocker(own + ivec2(round(max(reach * u, 1.0) * towards)), own, p, seen);
        if (!seen) continue;
        float d2 = max(dot(d, d), 1e-30);
        float rise = above_plane(dot(d, n) * inversesqrt(d2));
        if (rise <= highest) continue;
        sum += falloff(nearest(p, d)) * (rise * rise - highest * highest);
        highest = rise;
    }
    return sum;
}

float horizons(ivec2 own, vec3 p, vec3 n, float reach, float turn, float shift)
{
    float sum = 0.0;
    for (int i = 0; i < DIRECTIONS; ++i) {
        float angle = (float(i) + turn) * PI / float(DIRECTIONS);
        vec2 towards = vec2(cos(angle), sin(angle));
        sum += side_of_horizon(own, p, n, towards, reach, shift) + side_of_horizon(own, p, n, -towards, reach, shift);
    }
    return 1.0 - sum / float(2 * DIRECTIONS);
}

#if BENT
// Integrals over a slice of the cosine times a direction's part along v and across it, from v to an angle h: with
// cos t sin t cos(t - g) = (sin(3t - g) + sin(t + g)) / 4 and sin^2 t cos(t - g) = (2 cos(t - g) - cos(3t - g) - cos(t + g)) / 4.
vec2 direction_to(float h, float gamma)
{
    float along = (4.0 * cos(gamma) - cos(3.0 * h - gamma) - 3.0 * cos(h + gamma)) / 12.0;
    float across = (6.0 * sin(h - gamma) + 8.0 * sin(gamma) - sin(3.0 * h - gamma) - 3.0 * sin(h + gamma)) / 12.0;
    return vec2(along, across);
}
#endif

// Takes from `open` (its part along v and across it, its size) what is hidden on one side of a slice. What newly covers
// sectors counts by its fall-off. `side`: 1 or -1.
void hide(ivec2 own, vec3 p, vec3 n, Slice s, float side, vec2 towards, float reach, float shift, inout uint covered,
          inout vec3 open)
{
    float last = side > 0.0 ? 32.0 : 0.0;
    float far_before = view_depth(p);
    float way_before = 0.0;
    float each = sector_weight(s);
#if 1
    vec2 room = mix(vec2(own), view.size.xy - 1.0 - vec2(own), greaterThan(towards, vec2(0.0))) / max(abs(towards), vec2(1e-6));
    reach = min(reach, max(min(room.x, room.y), 1.0));
#endif
    for (int j = 0; j < STEPS; ++j) {
        float u = (float(j) + shift) / float(STEPS);
        float way = max(reach * u * u, 1.0);
        bool seen;
        ivec2 pixel = own + ivec2(round(way * towards));
        vec3 d = blocker(pixel, own, p, seen);
        if (!seen) {
            if (pixel != own) far_before = -1.0;
            continue;
        }
        float d2 = max(dot(d, d), 1e-30);
        float far = view_depth(p + d);
        vec3 away = -safe_normalize(view_vector(p + d));
        vec2 seen_at = place_in(s, d, n, side);
        float front = sector_of(s, seen_at);
        bool joined = far_before > 0.0 && abs(far - far_before) < ao.thickness + FALL * (way - way_before) / pixels_per_metre(far);
        float before = last;
        last = front;
        far_before = far;
        way_before = way;
        float rise = dot(d, n) * inversesqrt(d2);
        float hides = falloff(nearest(p, d)) * smoothstep(ao.bias, 2.0 * ao.bias, rise);
        if (!(hides > 0.0)) continue;
        uint bits = bits_between(s, front, sector_of(s, place_in(s, d + away * ao.thickness, n, side)));
        if (joined) bits |= bits_between(s, before, front);
        bits &= ~covered;
        covered |= bits;
        float part = hides * each * float(bitCount(bits));
        open.z -= part;
#if BENT
        open.xy -= part * seen_at.yx;
#endif
    }
}

// Slices are spread evenly around what p is seen along, not around the picture's axis, so that also at the picture's edge
// they make up the whole hemisphere.
vec4 ground_truth(ivec2 own, vec3 p, vec3 n, float reach, float turn, float shift)
{
    vec3 v = safe_normalize(view_vector(p));
    vec3 right = safe_normalize(view.place_x.xyz);
    vec3 first = safe_normalize(right - dot(right, v) * v);
    vec3 second = cross(v, first);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < DIRECTIONS; ++i) {
        float angle = (float(i) + turn) * PI / float(DIRECTIONS);
        Slice s = slice_at(v, n, first, second, angle, fract(shift + float(i) * 0.618034));
        vec2 towards = picture_direction(p, s.side);
        vec3 open = vec3(0.0, 0.0, 1.0);  // the mean of all slices, so that nothing hidden is exactly that
#if BENT
        open.xy = s.size * (direction_to(s.gamma + 0.5 * PI, s.gamma) + direction_to(s.gamma - 0.5 * PI, s.gamma));
#endif
        uint covered = 0u;
        hide(own, p, n, s, 1.0, towards, reach, shift, covered, open);
        hide(own, p, n, s, -1.0, -towards, reach, shift, covered, open);
        sum += vec4(open.x * v + open.y * s.side, open.z);
    }
    return sum / float(DIRECTIONS);
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 own = texel * STRIDE;
    if (own.x >= int(view.size.x) || own.y >= int(view.size.y)) return;
    float depth = surface_depth(own);
    vec4 visible = vec4(0.0, 0.0, 0.0, 1.0);  // the mean open direction, not of length 1; how much is open
    vec3 offset = vec3(0.0);
    if (depth > 0.0 && ao.strength > 0.0) {
        vec3 p = place_at(own, depth);
        vec3 n = surface_normal(own, p, depth);
        float pixels = ao.radius * pixels_per_metre(view_depth(p));
        float reach = min(pixels, view.size.y);
        if (reach > 1.0) {
            float turn = fract((float(pattern(texel)) + 0.5) / 16.0 + ao.turn);
            float shift = fract((float(pattern(texel.yx + ivec2(1, 2))) + 0.5) / 16.0 + ao.shift);
#if METHOD == 0
            visible.w = alchemy(own, p, n, reach, turn);
#elif METHOD == 1
            visible.w = horizons(own, p, n, reach, turn, shift);
#else
            visible = ground_truth(own, p, n, reach, turn, shift);
#endif
            // a radius of two pixels and less is no picture of its surroundings
            float part = ao.strength * sat(reach - 1.0);
            visible.w = mix(1.0, visible.w, part);
            offset = part * (safe_normalize(visible.xyz) - n);
        }
    }
    // one slice may well see more than 1 or less than 0, as others see less or more: it is the filtered value that ends there
    float open = visible.w == visible.w ? clamp(visible.w, -4.0, 4.0) : 1.0;
    imageStore(i_visibility, texel, TEXEL(vec4(offset == offset ? offset : vec3(0.0), open)));
}
