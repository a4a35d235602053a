#include "lib/math.glsl"

// What is left of a sample's own light, and the light scattered into its pixel. With nothing scattered it is the sample,
// to the bit.
#if BLOOM
layout(binding = 26) uniform sampler2D t_bloom;
#endif

vec3 with_bloom(vec3 own, ivec2 pixel, float kept, float scattered)
{
#if BLOOM
    return sanitise(own * kept + scattered * texelFetch(t_bloom, pixel, 0).rgb);
#else
    return own;
#endif
}
