// Tiled deferred lighting: every pixel adds the lights of its tile's list to what it has, and writes the HDR target.
#include "lib/gbuffer_read.glsl"
#include "lib/local_lights.glsl"
#include "lib/view.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_light_sum;
layout(binding = 1, rgba16f) uniform writeonly image2D i_hdr;

void main()
{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (pixel.x >= int(view.size.x) || pixel.y >= int(view.size.y)) return;
    float depth = texelFetch(t_depth, pixel, 0).r;
    if (!(depth > 0.0)) return;  // the background is there already
    vec3 color = sanitise(texelFetch(t_light_sum, pixel, 0).rgb);
    vec3 p = position_from_depth(vec2(pixel) + 0.5, depth);
    Reflector r = unpack_surface(gbuffer_texels(pixel), safe_normalize(view_vector(p)));
    color = add_local_lights(color, uvec2(pixel), p, r, 0);
    imageStore(i_hdr, pixel, vec4(sanitise(color), 1.0));
}
