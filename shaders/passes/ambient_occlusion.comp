// How much of the surroundings each pixel sees, cosine-weighted, from depth alone. What hides them counts less with its
// distance d: by 1 - (d / radius)^2.
//
// METHOD 0  Alchemy: McGuire, Osman, Bukowski, Hennessy 2011, "The Alchemy Screen-Space Ambient Obscurance Algorithm",
//           eq. 10, with our fall-off in place of 1/d, on a spiral (McGuire, Mara, Luebke 2012, eq. 7; Vogel 1979)
// METHOD 1  horizons: Bavoil, Sainz, Dimitrov 2008, "Image-Space Horizon-Based Ambient Occlusion", eq. 3; weighted by
//           the cosine as light is, so with the squares of the sines, and measured from the tangent plane
// METHOD 2  ground truth: Jimenez, Wu, Pesce, Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect
//           Occlusion", eq. 7 to 9; the horizon sinks with distance step by step, not as a whole, which
//           left a wall of infinite height half as dark as it is (0.25 for 0.40 at half the radius)
#include "lib/surface_from_depth.glsl"
#include "lib/ambient_texels.glsl"
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

// A place in a pattern of 4 x 4 pixels, 0 to 15, far from those beside it (Bayer 1973).
int pattern(ivec2 pixel)
{
    int x = pixel.x & 3;
    int y = pixel.y & 3;
    int z = x ^ y;
    return ((y >> 1) & 1) | ((z & 2)) | ((y & 1) << 2) | ((z & 1) << 3);
}

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
        ivec2 texel = min(pixel >> level, textureSize(t_depths, level - 1) - 1);
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

// Integrals over a slice from v to a horizon at h, `gamma` being the normal's angle in it: x, of the cosine; y and z, of the
// cosine times the direction's part along v and across it. x is a of eq. 8; the others follow from
// cos t sin t cos(t - g) = (sin(3t - g) + sin(t + g)) / 4 and sin^2 t cos(t - g) = (2 cos(t - g) - cos(3t - g) - cos(t + g)) / 4.
vec3 arc(float h, float gamma)
{
    vec3 a = vec3(0.25 * (cos(gamma) + 2.0 * h * sin(gamma) - cos(2.0 * h - gamma)), 0.0, 0.0);
#if BENT
    a.y = (4.0 * cos(gamma) - cos(3.0 * h - gamma) - 3.0 * cos(h + gamma)) / 12.0;
    a.z = (6.0 * sin(h - gamma) + 8.0 * sin(gamma) - sin(3.0 * h - gamma) - 3.0 * sin(h + gamma)) / 12.0;
#endif
    return a;
}

// What is open of one side of a slice (`side` 1 or -1). As the horizon rises, what it newly hides counts by the fall-off of
// what hides it. Elevations are taken from the tangent plane and not from v, so that a place beside the slice, at the
// middle of its pixel, hides nothing of its own plane.
vec3 open_arc(ivec2 own, vec3 p, vec3 n, vec2 towards, float reach, float shift, float gamma, float size, float side)
{
    float highest = 0.0;
    vec3 last = arc(gamma + side * 0.5 * PI, gamma);
    vec3 open = last;
    for (int j = 0; j < STEPS; ++j) {
        float u = (float(j) + shift) / float(STEPS);
        bool seen;
        vec3 d = blocker(own + ivec2(round(max(reach * u * u, 1.0) * towards)), own, p, seen);
        if (!seen) continue;
        float d2 = max(dot(d, d), 1e-30);
        float rise = min(above_plane(dot(d, n) * inversesqrt(d2)) / size, 1.0);
        if (rise <= highest) continue;
        highest = rise;
        vec3 now = arc(gamma + side * (0.5 * PI - asin(rise)), gamma);
        open -= falloff(nearest(p, d)) * (last - now);
        last = now;
    }
    return open;
}

// The way over the picture (rows go down) of a step from p along `side`, which is at a right angle to what p is seen along.
vec2 over_picture(vec3 to_eye, vec3 side, vec3 right, vec3 up)
{
    vec2 step_ = vec2(dot(side, right), dot(side, up));
    if (view.camera.w > 0.5) {
        vec3 back = cross(right, up);
        step_ -= dot(side, back) / max(dot(to_eye, back), 1e-30) * vec2(dot(to_eye, right), dot(to_eye, up));
    }
    return vec2(step_.x, -step_.y) * inversesqrt(max(dot(step_, step_), 1e-30));
}

// Slices are spread evenly around what p is seen along, not around the picture's axis, so that also at the picture's edge
// they make up the whole hemisphere.
vec4 ground_truth(ivec2 own, vec3 p, vec3 n, float reach, float turn, float shift)
{
    vec3 to_eye = view_vector(p);
    vec3 v = safe_normalize(to_eye);
    vec3 right = safe_normalize(view.place_x.xyz);
    vec3 up = safe_normalize(view.place_y.xyz);
    vec3 across = safe_normalize(right - dot(right, v) * v);
    vec3 upward = cross(v, across);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < DIRECTIONS; ++i) {
        float angle = (float(i) + turn) * PI / float(DIRECTIONS);
        vec3 side = across * cos(angle) + upward * sin(angle);
        vec2 towards = over_picture(to_eye, side, right, up);
        vec3 axis = cross(side, v);
        vec3 projected = n - axis * dot(n, axis);
        float size = max(length(projected), 1e-6);
        float gamma = sign(dot(side, projected)) * acos(clamp(dot(projected, v) / size, -1.0, 1.0));
        vec3 open = open_arc(own, p, n, towards, reach, shift, gamma, size, 1.0)
                  + open_arc(own, p, n, -towards, reach, shift, gamma, size, -1.0);
        sum += size * vec4(open.y * v + open.z * side, open.x);
    }
    return sum / float(DIRECTIONS);
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 own = texel * STRIDE;
    if (own.x >= int(view.size.x) || own.y >= int(view.size.y)) return;
    float depth = depth_at(own);
    vec4 visible = vec4(0.0, 0.0, 0.0, 1.0);  // the mean open direction, not of length 1; how much is open
    vec3 offset = vec3(0.0);
    if (depth > 0.0 && ao.strength > 0.0) {
        vec3 p = place_at(own, depth);
        vec3 n = facet_normal(own, p, depth);
        float pixels = ao.radius * pixels_per_metre(view_depth(p));
        float reach = min(pixels, 0.5 * view.size.y);
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
