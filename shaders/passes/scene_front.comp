// Level 0: depth of what may be seen through the transmissive body in its pixel; what is in front of that is nearer than all.
// Levels above: the nearest of the texels below, of the odd ones at the border, too. MS: the nearest sample.
#include "lib/scene_front.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1, r32f) uniform image2D i_front;
#if LEVEL == 0
layout(binding = 10) uniform sampler2D t_glass;
#if SAMPLES > 1
layout(binding = 20) uniform sampler2DMS t_depth;
#else
layout(binding = 20) uniform sampler2D t_depth;
#endif
#endif

const float NOWHERE = 1e30;

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, front_size(LEVEL)))) return;
    float nearest = 0.0;
#if LEVEL > 0
    ivec2 size = front_size(LEVEL - 1);
    ivec2 corner = front_corner(LEVEL - 1);
    ivec2 last = min(2 * texel + 1 + (size & 1), size - 1);
    for (int y = 2 * texel.y; y <= last.y; ++y)
        for (int x = 2 * texel.x; x <= last.x; ++x) nearest = max(nearest, imageLoad(i_front, corner + ivec2(x, y)).r);
#else
    for (int s = 0; s < SAMPLES; ++s) nearest = max(nearest, texelFetch(t_depth, texel, s).r);
    float glass = texelFetch(t_glass, texel, 0).r;
    if (glass > 0.0 && nearest > glass) nearest = NOWHERE;
#endif
    imageStore(i_front, front_corner(LEVEL) + texel, vec4(nearest));
}
