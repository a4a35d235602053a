// Half the size: of four texels one stands for the place, its light is the mean of those that lie at its depth.
#include "lib/deep_layers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_depths;
layout(binding = 17) uniform sampler2D t_sides;
layout(binding = 18) uniform sampler2D t_sent0;
layout(binding = 19) uniform sampler2D t_sent1;
layout(binding = 1, rg32f) uniform writeonly image2D i_depth;
layout(binding = 2, rgba8) uniform writeonly image2D i_side;
layout(binding = 3, rgba16f) uniform writeonly image2D i_light0;
#if LAYERS > 1
layout(binding = 4, rgba16f) uniform writeonly image2D i_light1;
#endif

// Of a layer of that depth at `from`. Depths of one surface in neighbouring texels differ by a small part.
vec4 mean_light(sampler2D light, ivec2 corner, int layer, float depth)
{
    vec4 sum = vec4(0.0);
    if (!(depth > 0.0)) return sum;
    for (int k = 0; k < 4; ++k) {
        ivec2 at = min(corner + ivec2(k & 1, k >> 1), textureSize(t_depths, LEVEL - 1) - 1);
        vec2 depths = texelFetch(t_depths, at, LEVEL - 1).xy;
        float other = layer == 0 ? depths.x : depths.y;
        if (abs(other - depth) > 0.1 * depth) continue;
        sum += vec4(texelFetch(light, at, LEVEL - 1).rgb, 1.0);
    }
    return sum.a > 0.0 ? sum / sum.a : sum;
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(i_depth)))) return;
    ivec2 from = min(finer_texel(texel), textureSize(t_depths, LEVEL - 1) - 1);
    vec2 depth = texelFetch(t_depths, from, LEVEL - 1).xy;
    imageStore(i_depth, texel, vec4(depth, 0.0, 0.0));
    imageStore(i_side, texel, texelFetch(t_sides, from, LEVEL - 1));
    imageStore(i_light0, texel, mean_light(t_sent0, 2 * texel, 0, depth.x));
#if LAYERS > 1
    imageStore(i_light1, texel, mean_light(t_sent1, 2 * texel, 1, depth.y));
#endif
}
