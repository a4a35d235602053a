// What a blended surface is to light: a filter. Alpha: its depth in the map, of which the nearest is kept.
// After McGuire and Mara 2017, "Phenomenological transparency": of the light that meets it a surface lets 1 - alpha pass
// beside it, and alpha times its colour through it.
#include "lib/math.glsl"

#ifndef LAMPS
#define LAMPS 0
#endif
// effects without layers do not know these
#ifndef TRANSMISSION
#define TRANSMISSION 0
#define TRANSMISSION_MAP 0
#endif

layout(location = 2) flat in uint v_material;
#if HAS_UV0
layout(location = 4) in vec2 v_uv0;
#endif
#if UV1
layout(location = 5) in vec2 v_uv1;
#endif
#if VERTEX_COLOR
layout(location = 6) in vec4 v_color;
#endif
layout(location = 0) out vec4 o_tint;

void main()
{
    MaterialParams m = materials[v_material];
#if HAS_UV0
    vec2 uv0 = v_uv0;
#else
    vec2 uv0 = vec2(0.0);
#endif
#if UV1
    vec2 uv1 = v_uv1;
#else
    vec2 uv1 = uv0;
#endif
    vec4 color = m.base_color;
#if BASE_COLOR_MAP
    color *= sample_base_color_map(m, uv0, uv1);
#endif
#if VERTEX_COLOR
    color *= v_color;
#endif
#if ALPHA_TEST
    if (color.a < m.alpha_cutoff) discard;
#endif
#ifdef SOLID
    color.a = 1.0;
#endif
#if TRANSMISSION
    float through = m.transmission;
#if TRANSMISSION_MAP
    through *= sample_transmission_map(m, uv0, uv1).r;
#endif
    color.rgb *= through * (1.0 - m.metallic);
#endif
    vec3 left = mix(vec3(1.0), clamp(sanitise(color.rgb), 0.0, 1.0), coverage(color.a));
    if (left == vec3(1.0)) discard;  // not there, as far as light knows
#if LAMPS
    o_tint = vec4(left, min(gl_FragCoord.w, 65504.0));  // 1 at the tile's farthest, more nearer by
#else
    o_tint = vec4(left, gl_FragCoord.z);
#endif
}
