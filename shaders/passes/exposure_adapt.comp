// The log-mean luminance between two percentiles becomes middle grey (Reinhard, Stark, Shirley, Ferwerda 2002,
// "Photographic Tone Reproduction for Digital Images", eq. 1 and 2, with the percentiles); what is shown goes there by and by.
layout(local_size_x = 256) in;
layout(std430, binding = 2) readonly buffer HistogramBlock { uint histogram[]; };
layout(std430, binding = 3) buffer StateBlock { vec4 state; };
layout(std430, binding = 4) writeonly buffer ResultBlock { vec4 result; };
layout(binding = 1, r32f) uniform writeonly image2D i_exposure;

const int BINS = 128;
shared uint s_bins[2 * BINS];

void main()
{
    s_bins[gl_LocalInvocationIndex] = histogram[gl_LocalInvocationIndex];
    barrier();
    if (gl_LocalInvocationIndex != 0u) return;
    float total = 0.0;
    for (int i = 0; i < BINS; ++i) total += float(s_bins[i]);
    // at least a pixel is looked at, if there is one
    float from = min(exposure.low, exposure.high) * total - 0.5;
    float to = max(exposure.low, exposure.high) * total + 0.5;
    float passed = 0.0;
    float weight = 0.0;
    float sum = 0.0;
    for (int i = 0; i < BINS; ++i) {
        float next = passed + float(s_bins[i]);
        float part = max(min(next, to) - max(passed, from), 0.0);
        weight += part;
        float place = (float(s_bins[BINS + i]) / max(float(s_bins[i]), 1.0) + 0.5) / 16.0;
        sum += part * ((float(i) + place) / 4.0 - 16.0);
        passed = next;
    }
    float target = weight > 0.0 ? clamp(exposure.grey - sum / weight, -exposure.limit, exposure.limit) : 0.0;
    float before = state.x;
    float way = target < before ? exposure.darker : exposure.brighter;
    float now = exposure.known > 0.5 ? mix(before, target, way) : target;
    state = vec4(now, target, 0.0, 0.0);
    result = state;
    imageStore(i_exposure, ivec2(0), vec4(exp2(now)));
}
