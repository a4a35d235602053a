// Averages the visibility over the period of its pattern, on the same surface only, and brings it to full size: a joint
// bilateral filter (Petschnigg et al. 2004; Kopf et al. 2007) whose second distance is that from the pixel's own plane.
#include "lib/ambient_surface.glsl"
#include "lib/ambient_texels.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_visibility;
layout(binding = 1, FORMAT) uniform writeonly image2D i_filtered;

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (own.x >= int(view.size.x) || own.y >= int(view.size.y)) return;
    float depth = surface_depth(own);
    vec4 filtered = vec4(0.0, 0.0, 0.0, 1.0);
    if (depth > 0.0) {
        ivec2 middle = own / STRIDE;
        ivec2 last = textureSize(t_visibility, 0) - 1;
        vec3 p = place_at(own, depth);
        vec3 n = surface_normal(own, p, depth);
        float d = view_depth(p);
        // as far off its plane as a surface may be: a part of the radius, or of a pixel where that is more
        float slack = max(0.05 * ao.radius, 0.5 / pixels_per_metre(d));
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        for (int y = -2; y <= 2; ++y) {
            for (int x = -2; x <= 2; ++x) {
                ivec2 texel = middle + ivec2(x, y);
                if (any(lessThan(texel, ivec2(0))) || any(greaterThan(texel, last))) continue;
                float other = surface_depth(texel * STRIDE);
                if (!(other > 0.0) || is_floor(texel * STRIDE, other) != is_floor(own, depth)) continue;
                float off = abs(dot(place_at(texel * STRIDE, other) - p, n));
                // the outer rows count half: the window is one period wide
                float weight = (abs(x) == 2 ? 0.5 : 1.0) * (abs(y) == 2 ? 0.5 : 1.0) * sat(1.0 - off / slack);
                sum += weight * VISIBLE(texelFetch(t_visibility, texel, 0));
                weights += weight;
            }
        }
        filtered = weights > 1e-4 ? sum / weights : VISIBLE(texelFetch(t_visibility, min(middle, last), 0));
    }
    imageStore(i_filtered, own, TEXEL(vec4(filtered.xyz, sat(filtered.w))));
}
