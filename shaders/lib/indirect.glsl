#if GATHERED
// Light from other surfaces for those that stand in the depth it was gathered for: arriving light over pi, and what part
// of the environment's light is left beside it.
layout(binding = 28) uniform sampler2D t_indirect;

vec4 indirect_light(vec2 pixel)
{
    return texelFetch(t_indirect, ivec2(pixel), 0);
}
#endif
#if REFLECTIONS
// What mirrors see: radiance, and how sure it is.
layout(binding = 29) uniform sampler2D t_reflections;

vec4 reflected_light(vec2 pixel)
{
    vec2 size = vec2(textureSize(t_reflections, 0));  // that of the layers
    return texelFetch(t_reflections, ivec2(pixel * view.size.zw * size), 0);
}
#endif
