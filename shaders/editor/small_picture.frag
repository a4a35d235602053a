// A picture made small: the mean of nine places in what each pixel of it stands for.

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_source;
layout(location = 0) out vec4 o_color;

void main()
{
    vec2 third = vec2(dFdx(v_uv.x), dFdy(v_uv.y)) / 3.0;
    vec3 sum = vec3(0.0);
    for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x)
            sum += textureLod(t_source, v_uv + third * vec2(x, y), 0.0).rgb;
    o_color = vec4(sum / 9.0, 1.0);
}
