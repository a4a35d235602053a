// The mean of this frame's visibility and that of the frames before, found by motion. Of what was there before counts what
// lies in the pixel's own plane, as the filter has it, so that nothing is taken over from what hid it; and while anything
// changes it is held to the range of what is around (Salvi 2016, "An Excursion in Temporal Supersampling"), so that the
// darkness of a thing that went away goes with it. While nothing changes it is the plain mean.
#include "lib/ambient_surface.glsl"
#include "lib/motion.glsl"
#include "lib/ambient_texels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_visibility;
layout(binding = 28) uniform sampler2D t_before;
layout(binding = 29) uniform sampler2D t_before_state;
layout(binding = 30) uniform sampler2D t_motion;
layout(binding = 1, FORMAT) uniform writeonly image2D i_mean;
layout(binding = 2, rg32f) uniform writeonly image2D i_state;  // depth, how many frames are in it

// standard deviations of what is around that older ones may lie off
const float SPREAD = 1.0;
// pixels that a thing's own way differs from that of one that stands still
const float MOVED = 0.25;
// of the depth: how much of it a thing that moves itself may gain or lose in a frame
const float GAINED = 0.1;

vec4 now_at(ivec2 texel)
{
    return VISIBLE(texelFetch(t_visibility, clamp(texel, ivec2(0), textureSize(t_visibility, 0) - 1), 0));
}

// `seen` false where there is nothing to be had.
vec4 before_at(ivec2 texel, out vec2 state, out bool seen)
{
    state = texelFetch(t_before_state, texel, 0).xy;
    vec4 before = VISIBLE(texelFetch(t_before, texel, 0));
    seen = state.x > 0.0 && state.x <= 1.0 && state.y >= 1.0 && before == before;
    state.y = min(state.y, ao.most);
    return clamp(before, vec4(-4.0), vec4(4.0));
}

// How much of what a texel showed before lies in the plane through p, 0 to 1.
float same_plane(ivec2 texel, float depth, vec3 p, vec3 n, float slack)
{
    vec2 pixel = vec2(texel * STRIDE) + 0.5;
    vec2 ndc = vec2(pixel.x * 2.0 * view.size.z - 1.0, 1.0 - pixel.y * 2.0 * view.size.w);
    vec4 now = ao.now_from_before * vec4(ndc, depth, 1.0);
    if (!(now.w > 0.0) || !(now.z > 0.0)) return 0.0;
    now /= now.w;
    vec2 place = vec2(0.5 + 0.5 * now.x, 0.5 - 0.5 * now.y) * view.size.xy + ao.jitter;
    return sat(1.0 - abs(dot(position_from_depth(place, now.z) - p, n)) / slack);
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(t_visibility, 0);
    if (any(greaterThanEqual(texel, size))) return;
    ivec2 own = texel * STRIDE;
    float depth = surface_depth(own);
    vec4 now = now_at(texel);
    float frames = 1.0;
    vec2 state;
    bool seen;
    if (depth > 0.0 && ao.frozen > 0.5) {
        vec4 before = before_at(texel, state, seen);
        frames = seen ? min(state.y + 1.0, ao.most) : 1.0;
        if (seen) now = mix(before, now, 1.0 / frames);
    } else if (depth > 0.0 && ao.known > 0.5) {
        vec2 pixel = vec2(own) + 0.5 - ao.jitter;
        vec2 ndc = vec2(pixel.x * 2.0 * view.size.z - 1.0, 1.0 - pixel.y * 2.0 * view.size.w);
        vec4 clip = ao.before_from_now * vec4(ndc, depth, 1.0);
        vec2 moved = is_floor(own, depth) ? pixels_moved(ndc, clip) : texelFetch(t_motion, own, 0).rg;
        vec2 at = vec2(texel) - moved / float(STRIDE);
        // where it moved itself its plane then is not known, and its depth has to do
        bool itself = length(pixels_moved(ndc, clip) - moved) > MOVED;
        float expected = clip.z / max(clip.w, 1e-30);
        vec3 p = place_at(own, depth);
        vec3 n = surface_normal(own, p, depth);
        float slack = max(0.05 * ao.radius, 1.0 / pixels_per_metre(view_depth(p)));
        ivec2 corner = ivec2(floor(at));
        vec4 sum = vec4(0.0);
        float count = 0.0;
        float weights = 0.0;
        for (int k = 0; k < 4; ++k) {
            ivec2 step_ = ivec2(k & 1, k >> 1);
            ivec2 from = corner + step_;
            if (any(lessThan(from, ivec2(0))) || any(greaterThanEqual(from, size))) continue;
            vec2 part = mix(1.0 - fract(at), fract(at), vec2(step_));
            float weight = part.x * part.y;
            if (!(weight > 0.0)) continue;
            vec4 before = before_at(from, state, seen);
            if (!seen) continue;
            weight *= itself ? float(abs(state.x - expected) < GAINED * expected) : same_plane(from, state.x, p, n, slack);
            sum += weight * before;
            count += weight * state.y;
            weights += weight;
        }
        if (weights > 0.02) {
            vec4 mean = vec4(0.0);
            vec4 squares = vec4(0.0);
            for (int k = 0; k < 9; ++k) {
                vec4 c = now_at(texel + ivec2(k % 3 - 1, k / 3 - 1));
                mean += c / 9.0;
                squares += c * c / 9.0;
            }
            vec4 spread = SPREAD * sqrt(max(squares - mean * mean, vec4(0.0)));
            vec4 held = clamp(sum / weights, mean - spread, mean + spread);
            frames = min(count / weights + 1.0, ao.most);
            now = mix(held, now, 1.0 / frames);
        }
    }
    imageStore(i_mean, texel, TEXEL(now));
    imageStore(i_state, texel, vec4(depth, frames, 0.0, 0.0));
}
