// What a smooth surface mirrors of the picture and of the layer behind it: the mirrored view marched through both layers in
// even steps on the screen (McGuire and Mara 2014, "Efficient GPU Screen-Space Ray Tracing", JCGT 3(4)), the place between
// two steps by halving. Surfaces are as thick as the layers are apart. Radiance, and how sure it is: not at all where the ray
// leaves the picture, sees a surface's back, or the lobe is too wide for one ray.
#include "lib/gather_read.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 21) uniform usampler2D t_matter;
layout(binding = 1, rgba16f) uniform writeonly image2D i_reflections;

const float SHARP = 0.35;  // perceptual roughness up to which one ray is the lobe
const float MATT = 0.7;    // and from which on it is none
const int HALVINGS = 5;

struct March {
    vec2 from;
    vec2 along;   // texels
    float near;   // 1 / view depth at its ends, or view depth where rays are parallel
    float far;
};

float ray_depth(March m, float k)
{
    float at = mix(m.near, m.far, k);
    return view.camera.w > 0.5 ? 1.0 / max(at, 1e-30) : at;
}

vec2 texel_at(vec3 p)
{
    vec4 clip = view.clip_from_origin * vec4(p, 1.0);
    vec2 ndc = clip.xy / max(clip.w, 1e-30);
    return vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * gi.size.xy;
}

float scene_depth(ivec2 texel, int layer)
{
    vec2 depths = texelFetch(t_depths, texel, 0).xy;
    float depth = layer == 0 ? depths.x : depths.y;
    return depth > 0.0 ? view_depth(layer_place(texel, depth)) : -1.0;
}

// Where between k0 and k1 the ray goes behind a layer.
bool crosses(March m, float k0, float k1, int layer, out ivec2 texel, out float k)
{
    float thick = gi.separation;
    k = k1;
    texel = ivec2(m.from + m.along * k1);
    float there = scene_depth(texel, layer);
    float now = ray_depth(m, k1);
    float before = ray_depth(m, k0);
    if (there < 0.0 || max(now, before) < there || min(now, before) > there + thick) return false;
    float low = k0;
    for (int i = 0; i < HALVINGS; ++i) {
        float middle = 0.5 * (low + k);
        ivec2 at = ivec2(m.from + m.along * middle);
        float d = scene_depth(at, layer);
        if (d > 0.0 && ray_depth(m, middle) >= d) {
            k = middle;
            texel = at;
        } else {
            low = middle;
        }
    }
    there = scene_depth(texel, layer);
    now = ray_depth(m, k);
    return there > 0.0 && now >= there * (1.0 - 1e-3) && now <= there + thick;
}

vec4 mirrored(ivec2 own, vec3 p, vec3 n, vec3 v, float roughness)
{
    vec3 r = reflect(-v, n);
    float reach = gi.distance;
    // no farther than just before the camera's plane
    float forward = view_depth(p + r) - view_depth(p);
    float depth = view_depth(p);
    if (view.camera.w > 0.5 && forward < 0.0) reach = min(reach, 0.95 * depth / -forward);
    vec3 end = p + r * reach;
    March m;
    m.from = vec2(own) + 0.5;
    m.along = texel_at(end) - m.from;
    m.near = view.camera.w > 0.5 ? 1.0 / max(depth, 1e-30) : depth;
    float end_depth = view_depth(end);
    m.far = view.camera.w > 0.5 ? 1.0 / max(end_depth, 1e-30) : end_depth;
    float length_px = length(m.along);
    if (!(length_px > 1.0)) return vec4(0.0);
    vec2 room = mix(m.from, gi.size.xy - m.from, greaterThan(m.along, vec2(0.0))) / max(abs(m.along), vec2(1e-6));
    float last = min(min(room.x, room.y) * 0.999, 1.0);
    float shift = (float(pattern(own)) + 0.5) / 16.0;
    float step_k = max(last / float(STEPS), 1.0 / length_px);
    float k0 = 1.5 / length_px;
    float k1 = k0;
    for (int i = 0; i <= STEPS && k1 < last; ++i) {
        float from = k1;
        k1 = min((float(i) + shift) * step_k + k0, last);  // the last one is at the border
        for (int layer = 0; layer < LAYERS; ++layer) {
            ivec2 texel;
            float k;
            if (!crosses(m, from, k1, layer, texel, k)) continue;
            if (!inside_layers(texel) || dot(side_of(texel, 0, layer), r) > 0.0) continue;
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
    }
    return vec4(0.0);
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
        result = mirrored(own, p, shape_normal(texelFetch(t_shape, own, 0).xy, v), v, roughness);
        result.a = result.a > 0.0 ? min(result.a, 1.0) * gi.strength : 0.0;
    }
    imageStore(i_reflections, own, vec4(sanitise(result.rgb), result.a));
}
