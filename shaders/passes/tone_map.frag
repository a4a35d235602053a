// HDR scene-linear -> exposure -> tone map -> sRGB bytes.
#include "lib/color.glsl"
#include "lib/math.glsl"
#include "lib/tone_map.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_hdr;
layout(location = 0) out vec4 o_color;

void main()
{
    vec4 hdr = texelFetch(t_hdr, ivec2(gl_FragCoord.xy), 0);
    vec3 c = sanitise(hdr.rgb) * tone_map.exposure_scale;
#if TONE_MAP == 1
    c = tone_map_agx(c);
#elif TONE_MAP == 2
    c = tone_map_aces(c);
#elif TONE_MAP == 3
    c = tone_map_neutral(c);
#endif
    o_color = vec4(srgb_from_linear(c), sat(hdr.a));
}
