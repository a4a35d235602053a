// The mean of the samples of a pixel, scene-linear.
#include "lib/math.glsl"
#include "lib/with_bloom.glsl"

layout(location = 0) in vec2 v_uv;
#if SAMPLES > 1
layout(binding = 10) uniform sampler2DMS t_hdr;
#else
layout(binding = 10) uniform sampler2D t_hdr;
#endif
layout(location = 0) out vec4 o_color;

void main()
{
    vec4 sum = vec4(0.0);
    for (int s = 0; s < SAMPLES; ++s) {
        vec4 hdr = texelFetch(t_hdr, ivec2(gl_FragCoord.xy), s);
        sum += vec4(sanitise(hdr.rgb), coverage(hdr.a));
    }
    o_color = sum * (1.0 / float(SAMPLES));
#if BLOOM
    o_color.rgb = with_bloom(o_color.rgb, ivec2(gl_FragCoord.xy), resolve.bloom_kept, resolve.bloom_scattered);
#endif
}
