// A bit per light and bin (4 x 4 tiles): whether the light can reach anything there. One invocation a word of 32 lights.
#include "lib/light_culling.glsl"
#include "lib/light_groups.glsl"

layout(local_size_x = 64) in;
layout(std430, binding = 2) readonly buffer ViewMaskBlock { uint view_mask[]; };
layout(std430, binding = 3) writeonly buffer BinMaskBlock { uint bin_mask[]; };
layout(std430, binding = 6) writeonly buffer BinPartBlock { uint bin_parts[]; };  // a bit per word of the bin's mask
layout(std430, binding = 4) readonly buffer BinBlock { uvec4 bin_depth[]; };

shared uint s_parts[2];

void main()
{
    uint local = gl_LocalInvocationIndex;
    if (local < 2u) s_parts[local] = 0u;
    barrier();
    uint word = gl_GlobalInvocationID.x;
    uvec2 bin = gl_WorkGroupID.yz;
    uint bin_index = bin.y * culling.bin_columns + bin.x;
    uint left = word < culling.words ? view_mask[word] : 0u;
    uint mask = 0u;
    uvec4 depths = bin_depth[bin_index];
    bool solid = (depths.z & 1u) != 0u;
    bool sky = (depths.z & 2u) != 0u;
    bool blended = culling.blended != 0u;
    if (left != 0u && (solid || blended)) {
        Frustum f;
        float side = float(BIN << view.tiles.x);
        frustum_planes(vec2(bin) * side, min(vec2(bin + 1u) * side, view.size.xy), f);
        // what is blended may stand anywhere from the eye to what is solid behind it
        f.near = blended ? 0.0 : uintBitsToFloat(depths.x);
        f.far = blended && sky ? 3e38 : uintBitsToFloat(depths.y);
        if (!group_meets(word, f)) left = 0u;
        while (left != 0u) {
            int bit = findLSB(left);
            left &= left - 1u;
            LightBound b = light_bound(word * 32u + uint(bit));
            float radius = b.radius + slack(b);
            if (!(b.radius < ENDLESS) || (in_planes(f, b, radius) && in_depth(f.near, f.far, view_depth(b.center), radius)))
                mask |= 1u << bit;
        }
    }
    if (word < culling.words) bin_mask[bin_index * culling.words + word] = mask;
    if (mask != 0u) atomicOr(s_parts[local / 32u], 1u << (local & 31u));
    barrier();
    if (local < 2u) bin_parts[bin_index * culling.parts + gl_WorkGroupID.x * 2u + local] = s_parts[local];
}
