// A picture of half the size, by quadratic B-splines: 6 x 6 texels for one. At the borders the picture is mirrored.
// Smooth as the 13 lookups of Jimenez 2014, "Next Generation Post Processing in Call of Duty: Advanced Warfare", but
// exact in the sum of light at odd sizes, too. CALM: as there (after Karis 2013), bright texels count less: calmer, but
// light is lost.
#include "lib/math.glsl"
#include "lib/bloom.glsl"
#include "lib/half_float.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#if SAMPLES > 1
layout(binding = 10) uniform sampler2DMS t_finer;
#else
layout(binding = 10) uniform sampler2D t_finer;
#endif
layout(binding = 1, rgba16f) uniform writeonly image2D i_coarser;

// 8 texels of at most twice the size, and 3 on either side
const int TILE = 22;
shared vec4 s_tile[TILE * TILE];

// Of a texel at `at` (in texels of the coarser picture, from the middle of its first one) for texel i of `count`; what
// belongs to a texel beyond the border belongs to its mirror image.
float weight(float at, int i, int count)
{
    float w = spline(at - float(i));
    if (i == 0) w += spline(at + 1.0);
    if (i == count - 1) w += spline(at - float(count));
    return w;
}

vec3 finer_at(ivec2 p)
{
    vec3 sum = vec3(0.0);
    for (int s = 0; s < SAMPLES; ++s) sum += sanitise(texelFetch(t_finer, p, s).rgb);
    return sum * (1.0 / float(SAMPLES));
}

void main()
{
    ivec2 size = ivec2(bloom.finer.xy);
    ivec2 count = ivec2(bloom.coarser.xy);
    vec2 ratio = bloom.finer.xy / bloom.coarser.xy;
    ivec2 corner = ivec2(floor((vec2(gl_WorkGroupID.xy * 8u) - 1.0) * ratio - 0.5));
    for (int k = int(gl_LocalInvocationIndex); k < TILE * TILE; k += 64) {
        ivec2 p = corner + ivec2(k % TILE, k / TILE);
        bool inside = all(greaterThanEqual(p, ivec2(0))) && all(lessThan(p, size));
        vec3 c = inside ? finer_at(p) : vec3(0.0);
#if CALM
        float counts = inside ? 1.0 / (1.0 + dot(c, vec3(0.2126, 0.7152, 0.0722))) : 0.0;
#else
        float counts = inside ? 1.0 : 0.0;
#endif
        s_tile[k] = vec4(c * counts, counts);
    }
    barrier();

    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(own, count))) return;
    ivec2 first = ivec2(floor((vec2(own) - 1.0) * ratio - 0.5));
    vec4 sum = vec4(0.0);
    for (int y = 0; y < 7; ++y) {
        ivec2 p = first + ivec2(0, y);
        if (p.y < 0 || p.y >= size.y) continue;
        float wy = weight((float(p.y) + 0.5) / ratio.y - 0.5, own.y, count.y);
        for (int x = 0; x < 7; ++x) {
            p.x = first.x + x;
            if (p.x < 0 || p.x >= size.x) continue;
            ivec2 t = p - corner;
            sum += wy * weight((float(p.x) + 0.5) / ratio.x - 0.5, own.x, count.x) * s_tile[t.y * TILE + t.x];
        }
    }
    imageStore(i_coarser, own, vec4(nearest_half(sum.rgb / max(sum.a, 1e-30)), 1.0));
}
