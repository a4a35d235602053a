// The depth of a mirror's picture as a colour, which can have mips: 0 where there is nothing.
layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_depth;
layout(location = 0) out float o_reach;

void main()
{
    o_reach = texelFetch(t_depth, ivec2(gl_FragCoord.xy), 0).r;
}
