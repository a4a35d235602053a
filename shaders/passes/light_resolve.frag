// The sum of light of a pixel, made safe. Where nothing solid is, the target keeps the background it was cleared to.
//   THREE_PASS: local light comes apart from the surfaces (light_volumes.frag) and meets them here. Its specular part is a
//   luminance; the diffuse light lends it the colour.
#if THREE_PASS
#include "lib/gbuffer_read.glsl"
#include "lib/position.glsl"
#include "lib/view.glsl"
layout(binding = 21) uniform sampler2D t_gathered;
#else
#include "lib/math.glsl"
layout(binding = 20) uniform sampler2D t_depth;
#endif

layout(binding = 10) uniform sampler2D t_light_sum;
layout(location = 0) out vec4 o_color;

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float depth = texelFetch(t_depth, pixel, 0).r;
    if (!(depth > 0.0)) discard;
    vec3 color = sanitise(texelFetch(t_light_sum, pixel, 0).rgb);
#if THREE_PASS
    vec4 gathered = texelFetch(t_gathered, pixel, 0);
    vec3 p = position_from_depth(gl_FragCoord.xy, depth);
    Reflector r = unpack_surface(gbuffer_texels(pixel), safe_normalize(view_vector(p)));
    float luminance = dot(gathered.rgb, vec3(0.2126, 0.7152, 0.0722));
    vec3 tint = luminance > 0.0 ? gathered.rgb / luminance : vec3(1.0);
    color += sanitise((1.0 - r.f0) * r.diffuse_albedo * gathered.rgb + r.f0 * tint * gathered.a);
#endif
    o_color = vec4(sanitise(color), 1.0);
}
