// The G-buffer's textures, for the passes that light it. `p`: pixel.
#include "lib/gbuffer.glsl"

layout(binding = 17) uniform usampler2D t_gbuffer0;
layout(binding = 18) uniform usampler2D t_gbuffer1;
#if GBUFFER_LAYOUT == 2
layout(binding = 19) uniform usampler2D t_gbuffer2;
#endif
layout(binding = 20) uniform sampler2D t_depth;

SurfaceTexels gbuffer_texels(ivec2 p)
{
    SurfaceTexels t;
    t.a = texelFetch(t_gbuffer0, p, 0).xy;
    t.b = texelFetch(t_gbuffer1, p, 0).xy;  // the narrow layout's second channel reads 0
#if GBUFFER_LAYOUT == 2
    t.c = texelFetch(t_gbuffer2, p, 0).x;
#else
    t.c = 0u;
#endif
    return t;
}
