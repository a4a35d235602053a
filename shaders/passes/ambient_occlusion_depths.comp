// Depth at half the size of the level before.
#include "lib/depth_read.glsl"
#include "lib/half_depths.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 1, r32f) uniform writeonly image2D i_depth;
#if LEVEL > 0
layout(binding = 17) uniform sampler2D t_depths;
#endif

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(i_depth)))) return;
#if LEVEL > 0
    imageStore(i_depth, texel, texelFetch(t_depths, finer_texel(texel), LEVEL - 1));
#else
    imageStore(i_depth, texel, vec4(depth_at(finer_texel(texel))));
#endif
}
