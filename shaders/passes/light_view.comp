// A bit per light: whether it can reach anything in view at all.
#include "lib/light_culling.glsl"
#include "lib/light_groups.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 2) writeonly buffer ViewMaskBlock { uint view_mask[]; };

void main()
{
    uint word = gl_GlobalInvocationID.x;
    if (word >= culling.words) return;
    Frustum f;
    frustum_planes(vec2(0.0), view.size.xy, f);
    f.near = 0.0;
    f.far = 3e38;
    uint mask = 0u;
    uint bits = group_meets(word, f) ? 32u : 0u;
    for (uint bit = 0u; bit < bits; ++bit) {
        uint i = word * 32u + bit;
        if (i >= view.counts.x) break;
        LightBound b = light_bound(i);
        float radius = b.radius + slack(b);
        if (!(b.radius < ENDLESS) || (in_planes(f, b, radius) && view_depth(b.center) >= -radius)) mask |= 1u << bit;
    }
    view_mask[word] = mask;
}
