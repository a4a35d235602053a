// What the layers hold for light that is gathered or mirrored, in all sizes.
#include "lib/deep_layers.glsl"
#include "lib/pixel_pattern.glsl"

layout(binding = 10) uniform sampler2D t_depths;
layout(binding = 17) uniform sampler2D t_sides;
layout(binding = 18) uniform sampler2D t_sent0;
layout(binding = 19) uniform sampler2D t_sent1;
layout(binding = 20) uniform usampler2D t_shape;

// A texel of `level`, and the one of the full size that it stands for.
ivec2 texel_of(ivec2 texel, int level, out ivec2 whole)
{
    ivec2 at = min(texel >> level, last_texel(textureSize(t_depths, 0), level));
    whole = whole_texel(at, level);
    return at;
}

vec3 sent_by(ivec2 at, int level, int layer)
{
    return layer == 0 ? texelFetch(t_sent0, at, level).rgb : texelFetch(t_sent1, at, level).rgb;
}

// The same of a larger piece, `coarser` sizes on, where that is of the place's own surface; and no more than CALM times the
// mean of the largest piece about it: a small bright spot that few places meet would make blotches.
vec3 calm_light(ivec2 whole, int level, int layer, float depth, int coarser)
{
    const float CALM = 4.0;
    int wide = min(level + coarser, LEVELS - 1);
    ivec2 at = min(whole >> level, last_texel(textureSize(t_depths, 0), level));
    vec3 light = sent_by(at, level, layer);
    for (int k = wide; k > level; --k) {
        at = min(whole >> k, last_texel(textureSize(t_depths, 0), k));
        vec2 depths = texelFetch(t_depths, at, k).xy;
        if (abs((layer == 0 ? depths.x : depths.y) - depth) < 0.1 * depth) {
            light = sent_by(at, k, layer);
            break;
        }
    }
    at = min(whole >> (LEVELS - 1), last_texel(textureSize(t_depths, 0), LEVELS - 1));
    vec3 about = CALM * max(sent_by(at, LEVELS - 1, 0), sent_by(at, LEVELS - 1, LAYERS - 1));
    return any(greaterThan(about, vec3(0.0))) ? min(light, max(about.r, max(about.g, about.b))) : light;
}

vec3 side_of(ivec2 at, int level, int layer)
{
    vec4 sides = texelFetch(t_sides, at, level);
    return unpack_side(layer == 0 ? sides.xy : sides.zw);
}

vec3 shape_normal(uvec2 shape, vec3 v)
{
    if (shape.x == NO_REFLECTION) return v;
    vec3 n = from_octahedral(unpackSnorm2x16(shape.x));
    // a normal map may turn a surface away from whom sees it
    float facing = dot(n, v);
    return facing < 0.05 ? safe_normalize(n + (0.05 - facing) * v) : n;
}
