// The gathered mean as the picture, with edges steepened: away from the mean of the four neighbours, but not beyond their
// range, so that nothing rings (after Lottes 2019, "FidelityFX CAS"). With sharpness 0 it is the mean itself.
#include "lib/half_float.glsl"
#include "lib/math.glsl"
#include "lib/taa.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_mean;
layout(binding = 1, rgba16f) uniform writeonly image2D i_hdr;

vec4 mean_at(ivec2 p) { return texelFetch(t_mean, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0); }

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(view.size.xy)))) return;
    vec4 own = mean_at(p);
    vec3 result = own.rgb;
    if (taa.sharpness > 0.0) {
        vec3 c = compressed(own.rgb);
        vec3 n = compressed(mean_at(p + ivec2(0, -1)).rgb);
        vec3 s = compressed(mean_at(p + ivec2(0, 1)).rgb);
        vec3 w = compressed(mean_at(p + ivec2(-1, 0)).rgb);
        vec3 e = compressed(mean_at(p + ivec2(1, 0)).rgb);
        vec3 low = min(c, min(min(n, s), min(w, e)));
        vec3 high = max(c, max(max(n, s), max(w, e)));
        result = expanded(clamp(c + taa.sharpness * (c - 0.25 * (n + s + w + e)), low, high));
    }
    imageStore(i_hdr, p, vec4(nearest_half(min(result, vec3(32000.0))), own.a));
}
