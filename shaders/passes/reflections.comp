// What a smooth surface mirrors of the picture and of the layer behind it: the mirrored view goes through both layers from
// texel to texel, and over larger pieces where all that is in them is behind it, or before it (reflection_depths.comp).
// Surfaces are as thick as the layers are apart. Radiance, and how sure it is: not at all where the ray leaves the picture,
// sees a surface's back, or the lobe is too wide for one ray.
#include "lib/gather_read.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 21) uniform usampler2D t_matter;
layout(binding = 22) uniform sampler2D t_ranges;
layout(binding = 1, rgba16f) uniform writeonly image2D i_reflections;

const float SHARP = 0.35;  // perceptual roughness up to which one ray is the lobe
const float MATT = 0.7;    // and from which on it is none

// Depth and 1 / view depth (view depth itself where rays are parallel) are affine along a ray in the picture.
struct March {
    vec2 from;
    vec2 along;    // texels
    vec2 depths;   // at its ends, reversed
    vec2 inverse;  // 1 / view depth there
};

float ray_depth(March m, float k)
{
    float at = mix(m.inverse.x, m.inverse.y, k);
    return view.camera.w > 0.5 ? 1.0 / max(at, 1e-30) : at;
}

float inverse_of(float depth) { return view.camera.w > 0.5 ? 1.0 / max(depth, 1e-30) : depth; }

vec3 texel_and_depth(vec3 p)
{
    vec4 clip = view.clip_from_origin * vec4(p, 1.0);
    vec3 ndc = clip.xyz / max(clip.w, 1e-30);
    return vec3(vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * gi.size.xy, ndc.z);
}

// Whether a ray between two view depths goes into what a layer shows at a texel, from its front.
bool meets(ivec2 texel, int layer, float depth, vec2 range, vec3 r)
{
    if (!(depth > 0.0)) return false;
    float there = view_depth(layer_place(texel, depth));
    return range.y >= there && range.x <= there + gi.separation && dot(side_of(texel, 0, layer), r) <= 0.0;
}

// `k`: along the ray, where it leaves its own texel; then where it meets something. The layer; -1: it meets nothing.
int march(March m, float last, vec3 r, inout float k, out ivec2 texel)
{
    const int TOP = RANGES;
    vec2 each = 1.0 / vec2(abs(m.along.x) > 1e-3 ? m.along.x : 1e-3, abs(m.along.y) > 1e-3 ? m.along.y : 1e-3);
    float beyond = 0.01 / length(m.along);  // a hundredth of a texel into the next one
    int level = 0;
    for (int i = 0; i < STEPS && k < last; ++i) {
        texel = ivec2(m.from + m.along * k);
        ivec2 cell = texel >> level;
        vec2 edge = (vec2((cell + ivec2(greaterThan(m.along, vec2(0.0)))) << level) - m.from) * each;
        float out_k = clamp(min(edge.x, edge.y), k, last);
        if (level > 0) {
            vec2 range = texelFetch(t_ranges, min(cell, last_texel(textureSize(t_ranges, 0), level - 1)), level - 1).xy;
            vec2 own = vec2(mix(m.depths.x, m.depths.y, k), mix(m.depths.x, m.depths.y, out_k));
            bool before = min(own.x, own.y) > range.x;
            if (!before) {
                level -= 1;
                continue;
            }
            level = min(level + 1, TOP);
        } else {
            vec2 depths = texelFetch(t_depths, texel, 0).xy;
            vec2 way = vec2(ray_depth(m, k), ray_depth(m, out_k));
            way = vec2(min(way.x, way.y), max(way.x, way.y));
            for (int layer = 0; layer < LAYERS; ++layer) {
                if (meets(texel, layer, layer == 0 ? depths.x : depths.y, way, r)) return layer;
            }
            if (min(mix(m.depths.x, m.depths.y, k), mix(m.depths.x, m.depths.y, out_k)) > depths.x) level = min(1, TOP);
        }
        k = out_k + beyond;
    }
    return -1;
}

vec4 mirrored(ivec2 own, float own_depth, vec3 p, vec3 n, vec3 v, float roughness)
{
    vec3 r = reflect(-v, n);
    float reach = gi.distance;
    // no farther than just before the camera's plane
    float forward = view_depth(p + r) - view_depth(p);
    float depth = view_depth(p);
    if (view.camera.w > 0.5 && forward < 0.0) reach = min(reach, 0.95 * depth / -forward);
    vec3 end = p + r * reach;
    vec3 end_at = texel_and_depth(end);
    March m;
    m.from = vec2(own) + 0.5;
    m.along = end_at.xy - m.from;
    m.depths = vec2(own_depth, end_at.z);
    m.inverse = vec2(inverse_of(depth), inverse_of(view_depth(end)));
    float length_px = length(m.along);
    if (!(length_px > 1.0)) return vec4(0.0);
    vec2 room = mix(m.from, gi.size.xy - m.from, greaterThan(m.along, vec2(0.0))) / max(abs(m.along), vec2(1e-6));
    float last = min(min(room.x, room.y) * 0.999, 1.0);
    float k = 1.5 / length_px;
    ivec2 texel;
    int layer = march(m, last, r, k, texel);
    if (layer < 0) return vec4(0.0);
    vec2 border = min(vec2(texel) + 0.5, gi.size.xy - vec2(texel) - 0.5) * gi.size.zw;
    float sure = sat(10.0 * min(border.x, border.y)) * (1.0 - smoothstep(SHARP, MATT, roughness));
    // a rough lobe is as wide as a part of the way it goes
    float wide = roughness * roughness * length_px * k;
    int level = clamp(int(floor(log2(max(wide, 1.0)))), 0, LEVELS - 1);
    ivec2 whole;
    ivec2 at = texel_of(texel, level, whole);
    vec3 light = sent_by(at, level, layer);
    if (light == vec3(0.0)) light = sent_by(texel, 0, layer);
    return vec4(light, sure);
}

void main()
{
    ivec2 own = ivec2(gl_GlobalInvocationID.xy);
    if (!inside_layers(own)) return;
    vec4 result = vec4(0.0);
    float depth = texelFetch(t_depths, own, 0).r;
    float roughness = unpackUnorm2x16(texelFetch(t_matter, own, 0).x).y;
    if (depth > 0.0 && gi.strength > 0.0 && roughness < MATT) {
        vec3 p = layer_place(own, depth);
        vec3 v = safe_normalize(view_vector(p));
        result = mirrored(own, depth, p, shape_normal(texelFetch(t_shape, own, 0).xy, v), v, roughness);
        result.a = result.a > 0.0 ? min(result.a, 1.0) * gi.strength : 0.0;
    }
    imageStore(i_reflections, own, vec4(sanitise(result.rgb), result.a));
}
