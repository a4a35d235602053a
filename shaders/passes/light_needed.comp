// Counts what a perfect list would hold: the entries of each tile's list that reach at least one of its solid pixels, and
// over all pixels the lights that reach each. For statistics only.
#include "lib/light_culling.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 16) uniform usampler2DArray t_light_tiles;
#if SAMPLES > 1
layout(binding = 20) uniform sampler2DMS t_depth;
#else
layout(binding = 20) uniform sampler2D t_depth;
#endif
layout(std430, binding = 5) readonly buffer LightListBlock { uint light_list[]; };
layout(std430, binding = 7) buffer CounterBlock { uint counters[]; };  // 5: entries needed, 6: counted, 7: by pixels
layout(std430, binding = 0) buffer SeenBlock { uint entry_seen[]; };
shared uint s_pixels;

int cluster_slice(float depth)
{
    return int(clamp(floor(log2(max(depth, 1e-30)) * view.clusters.x + view.clusters.y), 0.0, view.clusters.z - 1.0));
}

void main()
{
    if (gl_LocalInvocationIndex == 0u) s_pixels = 0u;
    barrier();
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x < int(view.size.x) && pixel.y < int(view.size.y)) {
        for (int s = 0; s < SAMPLES; ++s) {
            float z = texelFetch(t_depth, pixel, s).r;
            if (!(z > 0.0 && z <= 1.0)) continue;
            vec3 p = position_from_depth(vec2(pixel) + 0.5, z);
            int layer = view.clusters.z > 0.5 ? cluster_slice(view_depth(p)) : 0;
            uvec2 header = texelFetch(t_light_tiles, ivec3(uvec2(pixel) >> view.tiles.x, layer), 0).xy;
            if (header.y > view.counts.x) continue;
            for (uint k = header.x; k < header.x + header.y; ++k) {
                LightBound b = light_bound(light_list[k]);
                vec3 to = p - b.center;
                float d2 = dot(to, to);
                if (b.radius < ENDLESS && d2 > b.radius * b.radius) continue;
                if (dot(to, b.axis) < b.cos_angle * sqrt(d2)) continue;
                if (s == 0) atomicAdd(s_pixels, 1u);
                if (atomicExchange(entry_seen[k], 1u) == 0u) atomicAdd(counters[5], 1u);
            }
        }
    }
    barrier();
    if (gl_LocalInvocationIndex == 0u) atomicAdd(counters[7], s_pixels);
    if (gl_GlobalInvocationID.xy == uvec2(0u)) counters[6] = 1u;
}
