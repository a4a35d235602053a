// A joint bilateral filter (Petschnigg et al. 2004; Kopf et al. 2007) by the distance from the place's own plane, run three
// times: over the period of the pattern; over places a period apart, with holes (Dammertz et al. 2010, "Edge-Avoiding
// A-Trous Wavelet Transform for fast Global Illumination Filtering"); and, WHOLE, from the layers' size to the picture's.
// The second keeps what changes by more than the pattern's noise about the place.
//   RADIUS taps on each side, APART texels from one to the next
#if WHOLE
#include "lib/surface_from_depth.glsl"
#endif
#include "lib/deep_layers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_gathered;
layout(binding = 17) uniform sampler2D t_depths;
#if !WHOLE
layout(binding = 18) uniform sampler2D t_sides;
#endif
#if NOISY
layout(binding = 19) uniform sampler2D t_noisy;

float brightness(vec4 light) { return dot(light, vec4(0.333, 0.333, 0.333, 0.25)); }

// Of what was gathered at the nine texels about a place, before any filter.
float variance_at(ivec2 own)
{
    float mean = 0.0;
    float square = 0.0;
    for (int k = 0; k < 9; ++k) {
        ivec2 texel = clamp(own + ivec2(k % 3 - 1, k / 3 - 1), ivec2(0), ivec2(gi.size.xy) - 1);
        float b = brightness(texelFetch(t_noisy, texel, 0));
        mean += b / 9.0;
        square += b * b / 9.0;
    }
    return max(square - mean * mean, 0.0);
}
#endif
#if LAYER_VIEW
#include "lib/deep_texels.glsl"
layout(binding = 19) uniform usampler2D t_shape;
layout(binding = 21) uniform usampler2D t_light;
layout(binding = 22) uniform sampler2D t_layer_depth;

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
#if WHOLE
    if (own.x >= int(view.size.x) || own.y >= int(view.size.y)) return;
    float depth = depth_at(own);
    ivec2 middle = clamp(ivec2((vec2(own) + 0.5) / gi.scale), ivec2(0), ivec2(gi.size.xy) - 1);
#else
    if (!inside_layers(own)) return;
    float depth = texelFetch(t_depths, own, 0).r;
    ivec2 middle = own;
#endif
    vec4 filtered = vec4(0.0, 0.0, 0.0, 1.0);
    if (depth > 0.0) {
#if WHOLE
        vec3 p = place_at(own, depth);
        vec3 n = facet_normal(own, p, depth);
#else
        vec3 p = layer_place(own, depth);
        vec3 n = unpack_side(texelFetch(t_sides, own, 0).xy);
#endif
        // as far off its plane as a surface may be: a part of the radius, or of a texel where that is more
        float slack = max(0.01 * gi.radius, gi.scale.y / pixels_per_metre(view_depth(p)));
#if NOISY
        float own_light = brightness(texelFetch(t_gathered, own, 0));
        // of the mean over a window of the pattern, so of a part of it
        float noise = 0.25 * variance_at(own) + 1e-12;
#endif
        vec4 sum = vec4(0.0);
        float weights = 0.0;
        for (int y = -RADIUS; y <= RADIUS; ++y) {
            for (int x = -RADIUS; x <= RADIUS; ++x) {
                ivec2 texel = middle + APART * ivec2(x, y);
                if (!inside_layers(texel)) continue;
                float other = texelFetch(t_depths, texel, 0).r;
                if (!(other > 0.0)) continue;
                // the outer rows count half: the window is one period wide
                float weight = (abs(x) == RADIUS ? 0.5 : 1.0) * (abs(y) == RADIUS ? 0.5 : 1.0)
                             * sat(1.0 - abs(dot(layer_place(texel, other) - p, n)) / slack);
                vec4 light = texelFetch(t_gathered, texel, 0);
#if NOISY
                float change = brightness(light) - own_light;
                weight *= noise / (noise + change * change);
#endif
                sum += weight * light;
                weights += weight;
            }
        }
        filtered = weights > 1e-4 ? sum / weights : texelFetch(t_gathered, middle, 0);
    }
#if WHOLE
    filtered = gi.strength > 0.0 ? vec4(filtered.rgb * gi.strength, mix(1.0, filtered.a, gi.strength))
                                 : vec4(0.0, 0.0, 0.0, 1.0);
    filtered.a = min(filtered.a, 1.0);
#endif
#if LAYER_VIEW
    filtered.rgb = layer_view(middle);
#endif
    imageStore(i_filtered, own, vec4(sanitise(filtered.rgb), filtered.a > 0.0 ? filtered.a : 0.0));
}
