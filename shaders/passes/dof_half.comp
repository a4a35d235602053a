// The picture at half size with the discs' radii: of four pixels, those that are about as far off as the nearest of them.
// And the picture as it is, beside.
#include "lib/depth_read.glsl"
#define FOCUS 1
#include "lib/focus.glsl"
#include "lib/half_float.glsl"
#include "lib/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_hdr;
layout(binding = 1, rgba16f) uniform writeonly image2D i_half;
layout(binding = 2, rgba16f) uniform writeonly image2D i_sharp;

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    ivec2 last = ivec2(view.size.xy) - 1;
    if (any(greaterThan(2 * p, last))) return;
    float radii[4];
    float nearest = -1e9;
    for (int k = 0; k < 4; ++k) {
        radii[k] = disc_radius(depth_at(min(2 * p + ivec2(k & 1, k >> 1), last)));
        nearest = max(nearest, radii[k]);
    }
    vec4 sum = vec4(0.0);
    for (int k = 0; k < 4; ++k) {
        ivec2 q = 2 * p + ivec2(k & 1, k >> 1);
        vec4 c = texelFetch(t_hdr, min(q, last), 0);
        if (all(lessThanEqual(q, last))) imageStore(i_sharp, q, vec4(sanitise(c.rgb), coverage(c.a)));
        // light of all four goes somewhere: what is much farther off than the nearest counts little here
        float counts = 1.0 / (1.0 + 8.0 * max(abs(nearest - radii[k]) - 0.5, 0.0));
        sum += counts * vec4(sanitise(c.rgb), 1.0);
    }
    imageStore(i_half, p, vec4(nearest_half(sum.rgb / sum.a), stored_radius(nearest)));
}
