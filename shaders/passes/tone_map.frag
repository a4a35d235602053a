// HDR scene-linear -> exposure -> tone map -> mean of the samples -> sRGB bytes.
#include "lib/color.glsl"
#include "lib/math.glsl"
#include "lib/tone_map.glsl"
#include "lib/with_bloom.glsl"
#if VALUES
#include "lib/ramp.glsl"
#endif

layout(location = 0) in vec2 v_uv;
#if SAMPLES > 1
layout(binding = 10) uniform sampler2DMS t_hdr;
#else
layout(binding = 10) uniform sampler2D t_hdr;
#endif
#if METERED
layout(binding = 27) uniform sampler2D t_exposure;
#endif
layout(location = 0) out vec4 o_color;

vec4 display(vec4 hdr)
{
#if VALUES
    // a quantity of which there is none is black, one that is not known (alpha 0) grey
    if (!(hdr.r > 0.0)) return vec4(vec3(hdr.a > 0.0 ? 0.0 : 0.08), 1.0);
    float value = tone_map.ramp_log > 0.5 ? log2(hdr.r) : hdr.r;
    return vec4(ramp(value * tone_map.ramp_scale + tone_map.ramp_offset) * min(hdr.a, 1.0), 1.0);
#else
    // Every curve has long been white at 65504; beyond 1e19 the squares in some would overflow, and inf / inf is black.
    vec3 c = with_bloom(sanitise(hdr.rgb), ivec2(gl_FragCoord.xy), tone_map.bloom_kept, tone_map.bloom_scattered);
    float scale = tone_map.exposure_scale;
#if METERED
    if (tone_map.adapted > 0.5) scale *= texelFetch(t_exposure, ivec2(0), 0).r;
#endif
    c = min(c * scale, vec3(65504.0));
#if TONE_MAP == 1
    c = tone_map_agx(c);
#elif TONE_MAP == 2
    c = tone_map_aces(c);
#elif TONE_MAP == 3
    c = tone_map_neutral(c);
#endif
    return vec4(clamp(c, 0.0, 1.0), coverage(hdr.a));
#endif
}

void main()
{
    // With multisampling `s` is the sample, without it the only mip level: 0.
    vec4 sum = vec4(0.0);
    for (int s = 0; s < SAMPLES; ++s) sum += display(texelFetch(t_hdr, ivec2(gl_FragCoord.xy), s));
    sum *= 1.0 / float(SAMPLES);
    o_color = vec4(srgb_from_linear(sum.rgb), sum.a);
}
