// What the pass of that name found, for surfaces that stand in the depth it saw.
layout(binding = 25) uniform sampler2D t_ambient_visibility;

float ambient_visibility(vec2 pixel)
{
    return texelFetch(t_ambient_visibility, ivec2(pixel), 0).r;
}
