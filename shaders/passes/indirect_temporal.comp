// Mixes what was gathered with what the frames before had at the same place, and follows what moved itself (Mara et al.
// 2016, sect. 4.5), with what is kept held to the range of its neighbours now (Karis 2014, "High Quality Temporal
// Supersampling"), so that a light that goes out is gone at once; where nothing
// changed for a while it is the plain mean.
#include "lib/deep_layers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_gathered;
layout(binding = 17) uniform sampler2D t_depths;
layout(binding = 18) uniform sampler2D t_before;
layout(binding = 19) uniform sampler2D t_before_state;
layout(binding = 20) uniform sampler2D t_motion;  // of the view's pixels
layout(binding = 1, rgba32f) uniform writeonly image2D i_mixed;
layout(binding = 2, rg32f) uniform writeonly image2D i_state;  // how far it is, how many frames are in it

const float MOVED = 0.25;  // pixels that a thing's own way differs from that of one that stands still
const float NEAR = 0.05;   // of the depth: how far what was there may lie off
const float GAINED = 0.1;  // the same of what moved itself: how far it went towards or off is not known

// Where in the view a place of this frame, seen at `pixel` (without jitter), was in the frame before; and whether what is
// there moved itself. What was behind the camera was nowhere.
vec2 pixel_before(vec2 pixel, vec4 clip, out bool itself)
{
    vec2 size = gi.size.xy * gi.scale;
    vec2 ndc = clip.xy / clip.w;
    vec2 still = clip.w > 0.0 ? vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * size : vec2(-1e6);
    vec2 moved = texelFetch(t_motion, clamp(ivec2(pixel), ivec2(0), ivec2(size) - 1), 0).rg;
    itself = length(pixel - still - moved) > MOVED;
    return itself ? pixel - moved : still;
}

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (!inside_layers(own)) return;
    vec4 now = texelFetch(t_gathered, own, 0);
    float depth = texelFetch(t_depths, own, 0).r;
    float frames = 1.0;
    float far = 0.0;
    if (depth > 0.0) {
        vec3 p = layer_place(own, depth);
        far = view_depth(p);
        vec4 clip = gi.before_clip * vec4(p, 1.0);
        float expected = dot(gi.before_depth, vec4(p, 1.0));
        bool itself;
        vec2 pixel = pixel_before((vec2(own) + 0.5) * gi.scale - gi.jitter, clip, itself);
        vec2 at = pixel / gi.scale - 0.5;
        bool inside = all(greaterThan(pixel, vec2(0.0))) && all(lessThan(pixel, gi.size.xy * gi.scale));
        if (gi.known > 0.5 && inside) {
            float off = (itself ? GAINED : NEAR) * expected;
            ivec2 corner = ivec2(floor(at));
            vec2 part = fract(at);
            vec4 sum = vec4(0.0);
            float count = 0.0;
            float weights = 0.0;
            for (int k = 0; k < 4; ++k) {
                ivec2 texel = corner + ivec2(k & 1, k >> 1);
                if (!inside_layers(texel)) continue;
                vec2 state = texelFetch(t_before_state, texel, 0).xy;
                if (!(abs(state.x - expected) < off)) continue;
                vec2 w = mix(1.0 - part, part, vec2(k & 1, k >> 1));
                vec4 before = texelFetch(t_before, texel, 0);
                sum += w.x * w.y * vec4(sanitise(before.rgb), before.a > 0.0 ? min(before.a, 2.0) : 0.0);
                count += w.x * w.y * state.y;
                weights += w.x * w.y;
            }
            if (weights > 0.01) {
                vec4 mean = vec4(0.0);
                vec4 square = vec4(0.0);
                for (int k = 0; k < 9; ++k) {
                    ivec2 texel = clamp(own + ivec2(k % 3 - 1, k / 3 - 1), ivec2(0), ivec2(gi.size.xy) - 1);
                    vec4 c = texelFetch(t_gathered, texel, 0);
                    mean += c / 9.0;
                    square += c * c / 9.0;
                }
                vec4 spread = 2.0 * sqrt(max(square - mean * mean, vec4(0.0)));
                vec4 before = gi.rests > 0.5 ? sum / weights : clamp(sum / weights, mean - spread, mean + spread);
                frames = min(count / weights + 1.0, 1.0 / max(1.0 - gi.keep, 0.01));
                now += (before - now) * (1.0 - 1.0 / frames);
            }
        }
    }
    imageStore(i_mixed, own, vec4(sanitise(now.rgb), now.a > 0.0 ? min(now.a, 2.0) : 0.0));
    imageStore(i_state, own, vec4(far, frames, 0.0, 0.0));
}
