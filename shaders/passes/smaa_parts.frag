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

// Whether there is an edge from a corner of pixels to the next one in a direction. Corner (x, y) is the first of pixel (x, y).
bool edge(ivec2 corner, ivec2 direction)
{
    vec2 edges = edges_at(corner + min(direction, ivec2(0)));
    return (direction.x != 0 ? edges.g : edges.r) > 0.5;
}

// From `corner`, which an edge going `going` has reached, how far edges turn by turns, in steps of one pixel; and how they
// end: 1 by an edge of two pixels in the direction of the first `going`, -1 by one in the other, 0 by anything else.
vec2 stair(ivec2 corner, ivec2 going, ivec2 turn)
{
    float end = 1.0;
    for (int i = 0; i < 2 * STEPS; ++i) {
        bool straight = edge(corner, going);
        bool turns = edge(corner, turn);
        if (!turns || straight || edge(corner, -turn)) {
            // of a slanted line an edge of two pixels, and the next stair the same way; anything else is a corner
            ivec2 next = corner + going;
            bool slanted = straight && !turns && edge(next, turn) && !edge(next, going) && !edge(next, -turn);
            return vec2(float(i), slanted ? end : 0.0);
        }
        corner += turn;
        ivec2 other = going;
        going = turn;
        turn = other;
        end = -end;
    }
    return vec2(float(2 * STEPS), 0.0);
}

// Whether no step of a slanted line is at `corner`: neither beyond (x) nor on this side (y) is a crossing edge, or it goes
// on, and is a corner of something.
bool no_step(vec2 crossing, ivec2 corner, ivec2 across)
{
    return crossing.x + crossing.y < 0.5 || (crossing.x > 0.5 && edge(corner + across, across)) || (crossing.y > 0.5 && edge(corner - across, -across));
}

// Along the edge above pixel p (`across` points to the pixel beyond it): `own` picks that edge, 1 - own the crossing ones.
vec2 parts_of(ivec2 p, ivec2 along, ivec2 across, vec2 own)
{
    // the corner that the edge begins at, and the one where it ends
    ivec2 begins = p;
    ivec2 ends = p + along;
#if PATTERNS
    // which way a stair would go: at the end of the edge to this side, at its beginning beyond; or the other way round
    bool here = edge(ends, -across) || edge(begins, across);
    bool there = edge(begins, -across) || edge(ends, across);
    if (here != there) {
        vec2 after = here ? stair(ends, along, -across) : stair(begins, -along, -across);
        vec2 before = here ? stair(begins, -along, across) : stair(ends, along, across);
        float length = before.x + 1.0 + after.x;
        if (length >= SHORTEST) return smaa_stair(-before.y, after.y, length, before.x);
    }
#endif
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
#if PATTERNS
    // from corner to corner it is upright, as far as one can see
    if (no_step(first, begins - before * along, across) && no_step(last, ends + after * along, across)) return vec2(0.0);
#endif
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
