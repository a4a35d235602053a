// The widest disc before the plane of focus in each tile, in texels of half size.
#include "lib/focus.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_half;
layout(binding = 1, r16f) uniform writeonly image2D i_tiles;

void main()
{
    ivec2 tile = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = textureSize(t_half, 0);
    int n = int(dof.tile);
    if (any(greaterThanEqual(tile * n, size))) return;
    float widest = 0.0;
    ivec2 end = min((tile + 1) * n, size);
    for (int y = tile.y * n; y < end.y; ++y)
        for (int x = tile.x * n; x < end.x; ++x) widest = max(widest, kept_radius(texelFetch(t_half, ivec2(x, y), 0).a));
    imageStore(i_tiles, tile, vec4(widest));
}
