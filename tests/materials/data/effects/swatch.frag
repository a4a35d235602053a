#include "lib/mix.glsl"

layout(location = 0) in vec2 v_uv;
layout(location = 0) out vec4 o_color;

void main()
{
    MaterialParams m = materials[1];
    vec3 color = m.tint;
#if BASE_MAP
    color = combine(m.mode, color, sample_base_map(m, v_uv, v_uv + 10.0).rgb);
#endif
    if (m.flip == 1u) color = color.bgr;
    o_color = vec4(color * m.gain, m.shift.y);
}
