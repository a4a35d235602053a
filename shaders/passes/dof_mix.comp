// Sharp where it is sharp, blurred by how wide the pixel's own disc is, and what is before the plane of focus over it.
#include "lib/depth_read.glsl"
#define FOCUS 1
#include "lib/focus.glsl"
#include "lib/half_float.glsl"
#include "lib/math.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_sharp;
layout(binding = 11) uniform sampler2D t_half;
layout(binding = 12) uniform sampler2D t_behind;
layout(binding = 13) uniform sampler2D t_before;
layout(binding = 1, rgba16f) uniform writeonly image2D i_hdr;

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(view.size.xy)))) return;
    vec4 own = texelFetch(t_sharp, p, 0);
    float radius = disc_radius(depth_at(p));
    vec2 at = (vec2(p) + 0.5) * 0.5 - 0.5;
    ivec2 from = ivec2(floor(at));
    vec2 t = at - vec2(from);
    vec4 behind = vec4(0.0);
    vec4 before = vec4(0.0);
    ivec2 last = textureSize(t_half, 0) - 1;
    for (int k = 0; k < 4; ++k) {
        ivec2 corner = ivec2(k & 1, k >> 1);
        ivec2 q = clamp(from + corner, ivec2(0), last);
        vec2 w = mix(1.0 - t, t, vec2(corner));
        float weight = w.x * w.y;
        float other = 2.0 * kept_radius(texelFetch(t_half, q, 0).a);
        // of what is as blurred as this pixel is: what is sharp leaves no seam about itself
        float alike = weight / (0.1 + (other - radius) * (other - radius));
        behind += alike * vec4(texelFetch(t_behind, q, 0).rgb, 1.0);
        vec4 c = texelFetch(t_before, q, 0);
        before += weight * vec4(c.rgb * c.a, c.a);
    }
    vec3 blurred = behind.rgb / max(behind.a, 1e-6);
    vec3 result = mix(sanitise(own.rgb), blurred, smoothstep(0.75, 2.0, abs(radius)));
    result = result * (1.0 - before.a) + before.rgb;
    imageStore(i_hdr, p, vec4(nearest_half(min(result, vec3(32000.0))), coverage(own.a)));
}
