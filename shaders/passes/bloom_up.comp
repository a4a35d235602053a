// Twice the size by quadratic B-splines, and the picture of that size added by its part: halos of all widths in one.
#include "lib/bloom.glsl"
#include "lib/half_float.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_coarser;
#if OWN
layout(binding = 11) uniform sampler2D t_own;
#endif
layout(binding = 1, rgba16f) uniform writeonly image2D i_finer;

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(own, ivec2(bloom.finer.xy)))) return;
    ivec2 last = ivec2(bloom.coarser.xy) - 1;
    vec2 at = (vec2(own) + 0.5) * bloom.coarser.xy / bloom.finer.xy - 0.5;
    ivec2 middle = ivec2(round(at));
    vec3 sum = vec3(0.0);
    for (int y = -1; y <= 1; ++y) {
        float wy = spline(at.y - float(middle.y + y));
        for (int x = -1; x <= 1; ++x) {
            float w = wy * spline(at.x - float(middle.x + x));
            sum += w * texelFetch(t_coarser, clamp(middle + ivec2(x, y), ivec2(0), last), 0).rgb;
        }
    }
    sum *= bloom.coarser_part;
#if OWN
    sum += bloom.own_part * texelFetch(t_own, own, 0).rgb;
#endif
    imageStore(i_finer, own, vec4(nearest_half(sum), 1.0));
}
