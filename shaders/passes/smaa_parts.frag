// Follows the edges of a pixel to their ends, and says what part of the pixels on either side lies beyond the line.
#include "lib/smaa_area.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_edges;
layout(location = 0) out vec4 o_parts;  // of the edge above: the pixel above, this one; of the one to the left likewise

vec2 edges_at(ivec2 p)
{
    bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, ivec2(view.size.xy)));
    return inside ? step(0.5, texelFetch(t_edges, p, 0).rg) : vec2(0.0);
}

// Along the edge above pixel p (`across` points to the pixel beyond it): `own` picks that edge, 1 - own the crossing ones.
vec2 parts_of(ivec2 p, ivec2 along, ivec2 across, vec2 own)
{
    vec2 crossing = vec2(1.0) - own;
    int before = 0;
    vec2 first = vec2(0.0);
    for (int i = 0; i < STEPS; ++i) {
        // between pixel -i and the one before it: crossing edges, beyond and on this side
        ivec2 q = p - i * along;
        first = vec2(dot(edges_at(q + across), crossing), dot(edges_at(q), crossing));
        before = i;
        if (first.x + first.y > 0.5 || dot(edges_at(q - along), own) < 0.5) break;
    }
    int after = 0;
    vec2 last = vec2(0.0);
    for (int i = 0; i < STEPS; ++i) {
        ivec2 q = p + (i + 1) * along;
        last = vec2(dot(edges_at(q + across), crossing), dot(edges_at(q), crossing));
        after = i;
        if (last.x + last.y > 0.5 || dot(edges_at(q), own) < 0.5) break;
    }
    return smaa_area(first, last, float(before + after + 1), float(before));
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec2 edges = edges_at(p);
    o_parts = vec4(0.0);
    if (edges.g > 0.5) o_parts.rg = parts_of(p, ivec2(1, 0), ivec2(0, -1), vec2(0.0, 1.0));
    if (edges.r > 0.5) o_parts.ba = parts_of(p, ivec2(0, 1), ivec2(-1, 0), vec2(1.0, 0.0));
}
