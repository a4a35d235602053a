// How many pixels have which luminance, in quarters of a stop, and how far into its bin each lies, in sixteenths of it, so
// that means are finer than bins. Black has no luminance and does not count.
#include "lib/math.glsl"

layout(local_size_x = 16, local_size_y = 16) in;
#if SAMPLES > 1
layout(binding = 10) uniform sampler2DMS t_hdr;
#else
layout(binding = 10) uniform sampler2D t_hdr;
#endif
layout(std430, binding = 2) buffer HistogramBlock { uint histogram[]; };  // counts, then places in the bins

const int BINS = 128;
shared uint s_bins[2 * BINS];

void main()
{
    uint own = gl_LocalInvocationIndex;
    s_bins[own] = 0u;  // 256 threads
    barrier();
    ivec2 corner = ivec2(gl_WorkGroupID.xy) * 64 + ivec2(gl_LocalInvocationID.xy);
    for (int k = 0; k < 16; ++k) {
        ivec2 p = corner + 16 * ivec2(k & 3, k >> 2);
        if (p.x >= int(view.size.x) || p.y >= int(view.size.y)) continue;
        float luminance = dot(sanitise(texelFetch(t_hdr, p, 0).rgb), vec3(0.2126, 0.7152, 0.0722));
        if (!(luminance > exp2(-16.0))) continue;
        int at = clamp(int((log2(luminance) + 16.0) * 4.0 * 16.0), 0, BINS * 16 - 1);
        atomicAdd(s_bins[at >> 4], 1u);
        atomicAdd(s_bins[BINS + (at >> 4)], uint(at & 15));
    }
    barrier();
    if (s_bins[own] > 0u) atomicAdd(histogram[own], s_bins[own]);
}
