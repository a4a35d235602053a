// The picture dimmed, with the marked pixels over it: magenta NaN, yellow infinite, cyan negative, orange too bright.
// A white rim round those that are no numbers, so that a single one is seen.
layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform usampler2D t_marks;
layout(location = 0) out vec4 o_color;

const int RIM = 2;

void main()
{
    ivec2 at = ivec2(gl_FragCoord.xy);
    ivec2 last = textureSize(t_marks, 0) - 1;
    uint here = texelFetch(t_marks, at, 0).r;
    uint near = 0u;
    for (int y = -RIM; y <= RIM; ++y)
        for (int x = -RIM; x <= RIM; ++x) near |= texelFetch(t_marks, clamp(at + ivec2(x, y), ivec2(0), last), 0).r;
    o_color = vec4(0.0, 0.0, 0.0, 0.55);
    if ((here & 1u) != 0u) o_color = vec4(1.0, 0.0, 1.0, 1.0);
    else if ((here & 2u) != 0u) o_color = vec4(1.0, 1.0, 0.0, 1.0);
    else if ((near & 3u) != 0u) o_color = vec4(1.0);
    else if ((here & 4u) != 0u) o_color = vec4(0.0, 1.0, 1.0, 1.0);
    else if ((here & 8u) != 0u) o_color = vec4(1.0, 0.5, 0.0, 1.0);
}
