// Unit vectors in two numbers.

// No normal packs to this word: nothing is reflected.
const uint NO_REFLECTION = 0x80008000u;

// Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", JCGT 3(2), listings 1 and 2.
vec2 octahedral(vec3 n)
{
    vec2 p = n.xy / max(abs(n.x) + abs(n.y) + abs(n.z), 1e-20);
    vec2 side = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    return n.z < 0.0 ? (1.0 - abs(p.yx)) * side : p;
}

vec3 from_octahedral(vec2 p)
{
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    vec2 side = vec2(p.x >= 0.0 ? 1.0 : -1.0, p.y >= 0.0 ? 1.0 : -1.0);
    if (n.z < 0.0) n.xy = (1.0 - abs(n.yx)) * side;
    return normalize(n);
}
