layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_picture;
layout(location = 0) out vec4 o_color;

void main()
{
    vec4 color = texelFetch(t_picture, ivec2(gl_FragCoord.xy), 0);
    float outward = length(v_uv - 0.5) / length(vec2(0.5));
    o_color = vec4(color.rgb * (1.0 - p.strength * smoothstep(p.start, 1.0, outward)), color.a);
}
