// What is solid in a mirror's picture: what transmissive surfaces in it see behind them. Where there is nothing, black.
#include "lib/math.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2DArray t_planar;
layout(location = 0) out vec4 o_color;

void main()
{
    vec4 color = texelFetch(t_planar, ivec3(gl_FragCoord.xy, LAYER), 0);
    o_color = vec4(sanitise(color.rgb), coverage(color.a));
}
