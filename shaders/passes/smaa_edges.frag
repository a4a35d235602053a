// Where luma steps to the left of a pixel (r) and above it (g); not where a step twice as large is next to it, which is
// the edge then (Jimenez et al. 2012, section 4.1: local contrast adaptation).
layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_picture;
layout(location = 0) out vec2 o_edges;

const float LEAST = 0.1;
const float DROWNS = 0.5;

float luma_at(ivec2 p)
{
    vec3 c = texelFetch(t_picture, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0).rgb;
    return dot(c, vec3(0.2126, 0.7152, 0.0722));
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    float own = luma_at(p);
    float left = luma_at(p + ivec2(-1, 0));
    float above = luma_at(p + ivec2(0, -1));
    vec2 step = abs(own - vec2(left, above));
    o_edges = vec2(0.0);
    vec2 is_edge = vec2(greaterThanEqual(step, vec2(LEAST)));
    if (smaa.wanted < 0.5 || is_edge.x + is_edge.y == 0.0) return;

    float right = abs(own - luma_at(p + ivec2(1, 0)));
    float below = abs(own - luma_at(p + ivec2(0, 1)));
    float farther_left = abs(left - luma_at(p + ivec2(-2, 0)));
    float farther_above = abs(above - luma_at(p + ivec2(0, -2)));
    float largest = max(max(max(step.x, step.y), max(right, below)), max(farther_left, farther_above));
    o_edges = is_edge * vec2(greaterThanEqual(step, vec2(DROWNS * largest)));
}
