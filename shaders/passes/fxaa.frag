// Smooths edges of the finished picture: along an edge, how far it is to both of its ends says how much of the pixel lies
// beyond. After Lottes 2009, "FXAA" (NVIDIA white paper): contrast test, direction by second differences, search for the
// ends, blend for what is smaller than a pixel. Ours searches pixel by pixel and blends linear light.
#include "lib/color.glsl"
#include "lib/math.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_picture;
layout(location = 0) out vec4 o_color;

// contrast that is an edge: of all there is, and of the brightest pixel around
const float LEAST = 1.0 / 32.0;
const float PART = 1.0 / 8.0;
// of the blend of single pixels
const float SUBPIXEL = 0.75;

vec4 picture_at(ivec2 p) { return texelFetch(t_picture, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0); }

float luma_at(ivec2 p) { return dot(picture_at(p).rgb, vec3(0.299, 0.587, 0.114)); }

// How far it is to where the edge ends, and what the luma is off there.
vec2 end_of_edge(ivec2 p, ivec2 along, ivec2 across, float edge, float limit)
{
    float off = 0.0;
    for (int i = 1; i <= STEPS; ++i) {
        off = 0.5 * (luma_at(p + i * along) + luma_at(p + i * along + across)) - edge;
        if (abs(off) >= limit) return vec2(float(i), off);
    }
    return vec2(float(STEPS), off);
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec4 own = picture_at(p);
    o_color = own;
    float m = luma_at(p);
    float n = luma_at(p + ivec2(0, -1));
    float s = luma_at(p + ivec2(0, 1));
    float e = luma_at(p + ivec2(1, 0));
    float w = luma_at(p + ivec2(-1, 0));
    float highest = max(max(max(n, s), max(e, w)), m);
    float range = highest - min(min(min(n, s), min(e, w)), m);
    if (fxaa.wanted < 0.5 || range < max(LEAST, PART * highest)) return;

    float nw = luma_at(p + ivec2(-1, -1));
    float ne = luma_at(p + ivec2(1, -1));
    float sw = luma_at(p + ivec2(-1, 1));
    float se = luma_at(p + ivec2(1, 1));
    float around = (2.0 * (n + s + e + w) + nw + ne + sw + se) / 12.0;
    float single = smoothstep(0.0, 1.0, sat(abs(around - m) / range));
    single *= single * SUBPIXEL;

    float rows = abs(nw + sw - 2.0 * w) + 2.0 * abs(n + s - 2.0 * m) + abs(ne + se - 2.0 * e);
    float columns = abs(nw + ne - 2.0 * n) + 2.0 * abs(w + e - 2.0 * m) + abs(sw + se - 2.0 * s);
    bool lies = rows >= columns;
    float before = lies ? n : w;
    float after = lies ? s : e;
    bool back = abs(before - m) >= abs(after - m);
    ivec2 across = (lies ? ivec2(0, 1) : ivec2(1, 0)) * (back ? -1 : 1);
    ivec2 along = lies ? ivec2(1, 0) : ivec2(0, 1);
    float edge = 0.5 * (m + (back ? before : after));
    float limit = 0.25 * max(abs(before - m), abs(after - m));

    vec2 one = end_of_edge(p, -along, across, edge, limit);
    vec2 other = end_of_edge(p, along, across, edge, limit);
    vec2 nearer = one.x < other.x ? one : other;
    // the ends lie between pixels: half a pixel nearer than the first pixel beyond
    float part = 0.5 - (nearer.x - 0.5) / (one.x + other.x - 1.0);
    if ((m - edge < 0.0) == (nearer.y < 0.0)) part = 0.0;
    vec4 beyond = picture_at(p + across);
    part = max(part, single);
    vec3 mean = mix(linear_from_srgb(own.rgb), linear_from_srgb(beyond.rgb), part);
    o_color = vec4(srgb_from_linear(mean), mix(own.a, beyond.a, part));
}
