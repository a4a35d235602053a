// What blended casters leave of the first sun, as a colour: looked up as the shadows are, behind lib/shadows.glsl.
// Each is a filter (effects/surface_tint.frag); filters in a row are a product, in whatever order they are drawn.
// Of each texel only the nearest one's depth is known: what lies behind it is behind all of them.
layout(binding = 23) uniform sampler2DArray t_sun_tint;  // rgb: what is left; a: depth of the nearest, 0 where none

const float TINT_SHARPNESS = 1.0 - 1.0 / 2048.0;  // depths are kept as halves

#include "lib/tint_taps.glsl"

vec3 texel_taken(ivec2 texel, float layer, float depth)
{
    ivec2 last = textureSize(t_sun_tint, 0).xy - 1;
    vec4 t = texelFetch(t_sun_tint, ivec3(clamp(texel, ivec2(0), last), int(layer)), 0);
    return depth < t.a * TINT_SHARPNESS ? 1.0 - t.rgb : vec3(0.0);
}

// What is taken away at `at` from the point of the receiver, `own` being its place (both in texels): each texel is compared
// with the receiver's plane over its middle before they are mixed.
vec3 taken(ShadowReceiver r, vec2 own, vec2 at)
{
#if SHADOW_FILTER == 0
    vec2 texel = floor(at);
    return texel_taken(ivec2(texel), r.layer, plane_depth(r, own, texel + 0.5));
#else
    vec2 low = floor(at - 0.5);
    vec2 part = at - 0.5 - low;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        vec2 step = vec2(k & 1, k >> 1);
        vec2 weight = mix(1.0 - part, part, step);
        sum += weight.x * weight.y * texel_taken(ivec2(low + step), r.layer, plane_depth(r, own, low + step + 0.5));
    }
    return sum;
#endif
}

vec3 cascade_taken(int i, vec3 p, vec3 n, vec3 f, float turn)
{
    vec2 size = vec2(textureSize(t_sun_tint, 0).xy);
#if SHADOW_FILTER < 2
    ShadowReceiver r = receiver(i, p, n, f, 0.0);
    vec2 own = shadow_uv(r, vec2(0.0)).xy * size;
    return taken(r, own, own);
#else
    ShadowReceiver r = receiver(i, p, n, f, view.shadow.y);
    vec2 own = shadow_uv(r, vec2(0.0)).xy * size;
    vec2 direction = vec2(cos(turn), sin(turn));
    vec3 sum = vec3(0.0);
    for (int k = 0; k < TINT_TAPS; ++k) {
        sum += taken(r, own, own + direction * (view.shadow.y * vogel_radius(k, TINT_TAPS)));
        direction = GOLDEN_TURN * direction;
    }
    return sum / float(TINT_TAPS);
#endif
}

// What blended casters leave of the first sun at a point; exactly 1 where there are none. As `sun_visibility`.
vec3 sun_tint(vec3 p, vec3 n, vec3 f, uvec2 pixel)
{
    float edge;
    vec3 at = light_space(p);
    int i = cascade_of(at, 0, edge);
    if (i < 0) return vec3(1.0);
    vec3 n_light = light_space(n);
    vec3 f_light = light_space(f);
    float f2 = dot(f_light, f_light);
    f_light = f2 > 1e-30 ? f_light * inversesqrt(f2) : n_light;
    float turn = pixel_turn(pixel);
    vec3 gone = cascade_taken(i, at, n_light, f_light, turn);
    if (edge > 0.0) {
        float ignored;
        int next = cascade_of(at, i + 1, ignored);
        if (next >= 0) gone += (cascade_taken(next, at, n_light, f_light, turn) - gone) * edge;
    }
    float depth = -dot(vec4(view.view_from_origin[0].z, view.view_from_origin[1].z, view.view_from_origin[2].z,
                            view.view_from_origin[3].z), vec4(p, 1.0));
    return 1.0 - gone * (1.0 - sat((depth - view.shadow_fade.x) * view.shadow_fade.y));
}
