// One direction of the blur of a shadow map's moments: first along x, from depth; then along y, from what that gave. LAMPS:
// of one tile of the map of local lights, whose depth is 1e-6 m over the distance; else of one layer of the sun's.
#include "lib/shadow_moments.glsl"

#if SHADOW_FILTER == 8 && SHADOW_HALF
#define MOMENT_FORMAT r16f
#elif SHADOW_FILTER == 8
#define MOMENT_FORMAT r32f
#elif SHADOW_FILTER < 11 && SHADOW_HALF
#define MOMENT_FORMAT rg16f
#elif SHADOW_FILTER < 11
#define MOMENT_FORMAT rg32f
#elif SHADOW_HALF
#define MOMENT_FORMAT rgba16f
#else
#define MOMENT_FORMAT rgba32f
#endif

layout(local_size_x = 16, local_size_y = 8) in;
#if FIRST
#if LAMPS
layout(binding = 10) uniform sampler2D t_depth;
#else
layout(binding = 10) uniform sampler2DArray t_depth;
#endif
layout(binding = 1, MOMENT_FORMAT) uniform writeonly image2D i_moments;
#else
layout(binding = 10) uniform sampler2D t_rows;
#if LAMPS
layout(binding = 1, MOMENT_FORMAT) uniform writeonly image2D i_moments;
#else
layout(binding = 1, MOMENT_FORMAT) uniform writeonly image2DArray i_moments;
#endif
#endif

vec4 texel_at(ivec2 p)
{
#if FIRST && LAMPS
    float depth = texelFetch(t_depth, blur.corner + p, 0).r;
    return moments_of(2.0 * min(1e-6 / max(depth * blur.far, 1e-30), 1.0) - 1.0, blur.exponent);
#elif FIRST
    return moments_of(1.0 - 2.0 * texelFetch(t_depth, ivec3(p, blur.layer), 0).r, blur.exponent);
#else
    return texelFetch(t_rows, p, 0);
#endif
}

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    int last = blur.size - 1;
    if (any(greaterThan(own, ivec2(last)))) return;
    ivec2 along = FIRST != 0 ? ivec2(1, 0) : ivec2(0, 1);
    vec4 sum = texel_at(own) * blur.weights[0].x;
    for (int k = 1; k <= blur.taps; ++k) {
        float weight = blur.weights[k / 4][k % 4];
        sum += weight * (texel_at(max(own - k * along, ivec2(0))) + texel_at(min(own + k * along, ivec2(last))));
    }
#if FIRST
    imageStore(i_moments, own, sum);
#elif LAMPS
    imageStore(i_moments, blur.corner + own, sum);
#else
    imageStore(i_moments, ivec3(own, blur.layer), sum);
#endif
}
