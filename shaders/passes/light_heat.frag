// Lights per tile as colours: black none, then the ramp by log2 (engine/render/legends.py has the numbers); white where a
// list did not fit and all lights are meant. Of clusters, the longest list of the tile.
#include "lib/math.glsl"
#include "lib/ramp.glsl"

layout(location = 0) out vec4 o_color;
#if LISTS > 0
layout(binding = 16) uniform usampler2DArray t_light_tiles;
#endif

const float MOST = 1024.0;

float share(float count) { return log2(1.0 + count) / log2(1.0 + MOST); }

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint count = 0u;
#if LISTS > 0
    for (int list = 0; list < LISTS; ++list)
        count = max(count, texelFetch(t_light_tiles, ivec3(uvec2(pixel) >> view.tiles.x, list), 0).y);
#endif
    vec3 color = count == 0u ? vec3(0.0) : count > view.counts.x ? vec3(1.0) : ramp(share(float(count)));
    o_color = vec4(color, 0.75 * heat_block.covers);
}
