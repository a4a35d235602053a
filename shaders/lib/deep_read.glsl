// A texel of a layer, unpacked.
#include "lib/deep_texels.glsl"
#include "lib/octahedral.glsl"

layout(binding = 17) uniform usampler2D t_shape0;
layout(binding = 18) uniform usampler2D t_light0;
#if LAYERS > 1
layout(binding = 19) uniform usampler2D t_shape1;
layout(binding = 21) uniform usampler2D t_light1;
#endif

DeepSurface unpack_deep(uvec2 shape, uvec2 light)
{
    DeepSurface s;
    s.n = shape.x == NO_REFLECTION ? vec3(0.0) : from_octahedral(unpackSnorm2x16(shape.x));
    vec2 blue_rough = unpackUnorm2x16(light.x);
    s.albedo = vec3(unpackUnorm2x16(shape.y), blue_rough.x);
    s.roughness = blue_rough.y;
    s.emission = unpack_shared_exponent(light.y);
    return s;
}

DeepSurface deep_surface(ivec2 texel, int layer)
{
#if LAYERS > 1
    if (layer == 1) return unpack_deep(texelFetch(t_shape1, texel, 0).xy, texelFetch(t_light1, texel, 0).xy);
#endif
    return unpack_deep(texelFetch(t_shape0, texel, 0).xy, texelFetch(t_light0, texel, 0).xy);
}
