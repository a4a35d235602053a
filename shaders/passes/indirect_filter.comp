// Averages what was gathered over the period of its pattern, on the same surface only, and brings it to full size: a joint
// bilateral filter (Petschnigg et al. 2004; Kopf et al. 2007) by the distance from the pixel's own plane.
#include "lib/surface_from_depth.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_gathered;
layout(binding = 17) uniform sampler2D t_depths;
#if LAYER_VIEW
#include "lib/deep_texels.glsl"
layout(binding = 18) uniform usampler2D t_shape;
layout(binding = 19) uniform usampler2D t_light;
layout(binding = 21) uniform sampler2D t_layer_depth;

// Of the second layer: 1 albedo and emission, 2 how far it is.
vec3 layer_view(ivec2 texel)
{
    float depth = texelFetch(t_layer_depth, texel, 0).r;
    if (!(depth > 0.0)) return vec3(0.0);
#if LAYER_VIEW == 2
    return vec3(exp2(-2.0 * view_depth(position_from_depth((vec2(texel) + 0.5) * gi.scale, depth)) / gi.radius));
#else
    vec3 albedo = vec3(unpackUnorm2x16(texelFetch(t_shape, texel, 0).y), unpackUnorm2x16(texelFetch(t_light, texel, 0).x).x);
    return albedo + unpack_shared_exponent(texelFetch(t_light, texel, 0).y);
#endif
}
#endif
layout(binding = 1, rgba16f) uniform writeonly image2D i_filtered;

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (own.x >= int(view.size.x) || own.y >= int(view.size.y)) return;
    float depth = depth_at(own);
    vec4 filtered = vec4(0.0, 0.0, 0.0, 1.0);
    if (depth > 0.0) {
        ivec2 last = ivec2(gi.size.xy) - 1;
        ivec2 middle = clamp(ivec2((vec2(own) + 0.5) / gi.scale), ivec2(0), last);
        vec3 p = place_at(own, depth);
        vec3 n = facet_normal(own, p, depth);
        float d = view_depth(p);
        // as far off its plane as a surface may be: a part of the radius, or of a pixel where that is more
        float slack = max(0.01 * gi.radius, 1.0 / pixels_per_metre(d));
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        for (int y = -2; y <= 2; ++y) {
            for (int x = -2; x <= 2; ++x) {
                ivec2 texel = middle + ivec2(x, y);
                if (any(lessThan(texel, ivec2(0))) || any(greaterThan(texel, last))) continue;
                float other = texelFetch(t_depths, texel, 0).r;
                if (!(other > 0.0)) continue;
                vec3 place = position_from_depth((vec2(texel) + 0.5) * gi.scale, other);
                // the outer rows count half: the window is one period wide
                float weight = (abs(x) == 2 ? 0.5 : 1.0) * (abs(y) == 2 ? 0.5 : 1.0)
                             * sat(1.0 - abs(dot(place - p, n)) / slack);
                sum += weight * texelFetch(t_gathered, texel, 0);
                weights += weight;
            }
        }
        filtered = weights > 1e-4 ? sum / weights : texelFetch(t_gathered, middle, 0);
    }
    filtered = gi.strength > 0.0 ? vec4(filtered.rgb * gi.strength, mix(1.0, filtered.a, gi.strength))
                                 : vec4(0.0, 0.0, 0.0, 1.0);
#if LAYER_VIEW
    filtered.rgb = layer_view(clamp(ivec2((vec2(own) + 0.5) / gi.scale), ivec2(0), ivec2(gi.size.xy) - 1));
#endif
    imageStore(i_filtered, own, vec4(sanitise(filtered.rgb), filtered.a > 0.0 ? min(filtered.a, 1.0) : 0.0));
}
