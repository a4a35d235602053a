// What blended casters leave of a point, spot or area light, as a colour: looked up as its shadows are. As lib/shadow_tint.glsl.
#if !SOFT_LAMPS
layout(binding = 27) uniform sampler2D t_local_tint;
#endif
// rgb: what is left; a: how many times as far away as the nearest is what is farthest, 0 where none

const float LOCAL_TINT_SHARPNESS = 1.0 - 1.0 / 1024.0;  // kept as halves

#include "lib/tint_taps.glsl"

// along: of the receiver, in the unit of `a`.
vec3 lamp_texel_taken(ivec2 texel, float along)
{
    vec4 t = texelFetch(t_local_tint, clamp(texel, ivec2(0), textureSize(t_local_tint, 0) - 1), 0);
    return along < t.a * LOCAL_TINT_SHARPNESS ? 1.0 - t.rgb : vec3(0.0);
}

// What is taken away at uv: each texel is compared before they are mixed.
vec3 lamp_taken(vec2 uv, float along)
{
    vec2 at = uv * vec2(textureSize(t_local_tint, 0));
#if SHADOW_FILTER == 0
    return lamp_texel_taken(ivec2(floor(at)), along);
#else
    vec2 low = floor(at - 0.5);
    vec2 part = at - 0.5 - low;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        vec2 step = vec2(k & 1, k >> 1);
        vec2 weight = mix(1.0 - part, part, step);
        sum += weight.x * weight.y * lamp_texel_taken(ivec2(low + step), along);
    }
    return sum;
#endif
}

#if SOFT_LAMPS
vec3 soft_tint(uint i, vec4 head, vec3 q, vec3 n, uvec2 pixel)
{
    Light light = lights[i];
    float turn = pixel_turn(pixel);
    if (!soft_lifted(head, n, q)) return vec3(1.0);
    float spread = soft_spread(light, head, q, n, turn, true);
    if (spread < 0.0) return vec3(1.0);
    vec3 sum = vec3(0.0);
    for (int k = 0; k < SOFT_TAPS; ++k) {
        vec3 w = q + spread * lamp_point(light, q, lamp_sample(light, k, turn + 1.0));
        LampTap tap = lamp_tap(head, w);
        sum += lamp_taken(tap.uv, tap.far / max(soft_depth(tap, n, q, w), tap.near));
    }
    return 1.0 - sum / float(SOFT_TAPS);
}
#endif

// As local_visibility; exactly 1 where nothing tints.
vec3 local_tint(uint i, vec3 p, vec3 n, uvec2 pixel)
{
    vec4 head = local_shadows[i];
    if (head.y < 0.5) return vec3(1.0);
    vec3 q = p - lights[i].position;
#if SOFT_LAMPS
    if (head.w > 0.5) return soft_tint(i, head, q, dot(n, q) > 0.0 ? -n : n, pixel);
#endif
    LampReceiver r;
    if (!lamp_receiver(head, q, n, r)) return vec3(1.0);
    float along = r.far / max(r.depth - (LOCAL_CONSTANT + LOCAL_PER_RADIUS * r.radius) * r.texel, r.near);
#if SHADOW_FILTER < 2
    return 1.0 - lamp_taken(clamp(r.middle, r.low, r.high), along);
#else
    float turn = pixel_turn(pixel);
    vec2 direction = vec2(cos(turn), sin(turn));
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TINT_TAPS; ++k) {
        vec2 uv = r.middle + direction * (r.radius * r.unit * vogel_radius(k, TINT_TAPS));
        sum += lamp_taken(clamp(uv, r.low, r.high), along);
        direction = GOLDEN_TURN * direction;
    }
    return 1.0 - sum / float(TINT_TAPS);
#endif
}
