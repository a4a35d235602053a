// What the pass of that name found, for surfaces that stand in the depth it saw.
layout(binding = 25) uniform sampler2D t_ambient_visibility;

float ambient_visibility(vec2 pixel)
{
#if OPEN_DIRECTION
    return texelFetch(t_ambient_visibility, ivec2(pixel), 0).a;
#else
    return texelFetch(t_ambient_visibility, ivec2(pixel), 0).r;
#endif
}

#if OPEN_DIRECTION
// From the facet's normal to the mean of the directions that are open; 0 where nothing hides any.
vec3 open_offset_at(vec2 pixel)
{
    return texelFetch(t_ambient_visibility, ivec2(pixel), 0).rgb;
}
#endif
