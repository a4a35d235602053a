#include "lib/math.glsl"

// What is left of a sample's own light, and the light scattered into its pixel. With nothing scattered it is the sample,
// to the bit.
#if BLOOM
layout(binding = 26) uniform sampler2D t_bloom;
#endif

vec3 with_bloom(vec3 own, ivec2 pixel, float kept, float scattered)
{
#if BLOOM
    // no more than a picture as bright as sanitise allows would scatter here, so that the sum stays within it, too
    vec3 added = min(scattered * sanitise(texelFetch(t_bloom, pixel, 0).rgb), vec3(32000.0 * (1.0 - kept)));
    return own * kept + added;
#else
    return own;
#endif
}
