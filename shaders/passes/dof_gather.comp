// What falls on a pixel of half size: each place around gives its light evenly to the disc it is spread over. Behind the
// plane of focus nothing spreads over what is nearer; before it, it covers what is behind.
#include "lib/focus.glsl"
#include "lib/half_float.glsl"
#include "lib/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_half;
layout(binding = 11) uniform sampler2D t_tiles;
layout(binding = 1, rgba16f) uniform writeonly image2D i_behind;
layout(binding = 2, rgba16f) uniform writeonly image2D i_before;

const float GOLDEN = 2.39996323;

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(t_half, 0);
    if (any(greaterThanEqual(p, size))) return;
    vec4 own = texelFetch(t_half, p, 0);
    own.a = kept_radius(own.a);
    ivec2 tiles = textureSize(t_tiles, 0);
    ivec2 tile = p / int(dof.tile);
    float reach = 0.0;
    for (int k = 0; k < 9; ++k) {
        ivec2 q = tile + ivec2(k % 3 - 1, k / 3 - 1);
        if (all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, tiles))) reach = max(reach, texelFetch(t_tiles, q, 0).r);
    }
    reach = max(reach, abs(own.a));
    vec4 behind = vec4(0.0);
    vec4 before = vec4(0.0);
    if (reach < 0.5) {
        imageStore(i_behind, p, vec4(own.rgb, 1.0));
        imageStore(i_before, p, vec4(0.0));
        return;
    }
    reach += 0.5;  // a disc fades over a texel at its rim
    float per_tap = reach * reach / float(TAPS);  // area of a place over pi
    for (int i = 0; i < TAPS; ++i) {
        // Vogel 1979: even over the disc
        float off = i == 0 ? 0.0 : reach * sqrt((float(i) + 0.5) / float(TAPS));
        float turn = float(i) * GOLDEN;
        ivec2 q = clamp(p + ivec2(round(off * vec2(cos(turn), sin(turn)))), ivec2(0), size - 1);
        off = length(vec2(q - p));  // where it is, not where it was looked for: what is sharp stays in its texel
        vec4 c = texelFetch(t_half, q, 0);
        c.a = kept_radius(c.a);
        float radius = max(abs(c.a), 0.5);
        if (c.a <= 0.5) {
            // no farther over what is nearer than that is blurred itself; where that is before the plane, all of it
            // stands in for what it hides
            float spread = own.a > 0.5 ? reach : max(min(radius, abs(own.a)), 0.5);
            float counts = sat(spread - off + 0.5) / (own.a > 0.5 ? 1.0 : spread * spread);
            behind += counts * vec4(c.rgb, 1.0);
        }
        // what is nearly sharp stays as it is at full size
        float blurred = sat(2.0 * c.a - 1.0);
        if (blurred > 0.0) before += blurred * sat(radius - off + 0.5) * per_tap / (radius * radius) * vec4(c.rgb, 1.0);
    }
    vec3 filled = behind.a > 0.0 ? behind.rgb / behind.a : own.rgb;
    imageStore(i_behind, p, vec4(nearest_half(filled), 1.0));
    imageStore(i_before, p, vec4(nearest_half(before.rgb / max(before.a, 1e-6)), sat(before.a)));
}
