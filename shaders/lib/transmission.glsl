// What is seen through a surface: the picture of all that is solid, and the sky, looked up where the refracted ray leaves
// the body, in a blurrier mip the rougher it is. Without thickness the wall is thin and bends nothing.
//   REFRACTION: 0 straight, 1 bent, 2 bent, but never to what is in front of the body (engine/render/refraction.py)
layout(binding = 24) uniform sampler2D t_scene_color;
#if REFRACTION == 2
#include "lib/quad.glsl"
#include "lib/scene_front.glsl"
layout(binding = 17) uniform sampler2D t_scene_front;  // depth of what may be seen, and in halves the nearest

// Whether one of the texels that a lookup mixes, in this mip or a finer one, shows what is nearer than the surface.
bool in_front(vec2 at, int level)
{
    ivec2 size = front_size(level);
    ivec2 corner = front_corner(level);
    ivec2 low = ivec2(floor(at * vec2(size) - 0.5));
    float nearest = 0.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 texel = clamp(low + ivec2(k & 1, k >> 1), ivec2(0), size - 1);
        nearest = max(nearest, texelFetch(t_scene_front, corner + texel, 0).r);
    }
    return nearest > gl_FragCoord.z * 1.00001;
}

// The mip up to `lod` in which a lookup shows nothing that is in front; -1: none does.
float free_lod(vec2 at, float lod)
{
    for (int level = int(ceil(lod)); level >= 0; --level)
        if (!in_front(at, level)) return min(lod, float(level));
    return -1.0;
}
#endif

// Beer and Lambert; attenuation_color is what is left after attenuation_distance metres (0: nothing is taken).
vec3 absorbed(MaterialParams m, float way)
{
    if (m.attenuation_distance <= 0.0) return vec3(1.0);
    return exp(log(clamp(m.attenuation_color, vec3(1e-6), vec3(1.0))) * (way / m.attenuation_distance));
}

// What a surface reflects totally: light cannot leave the body there.
vec3 reflected_inside(vec3 n, vec3 v, float roughness)
{
#if ENVIRONMENT
    vec3 radiance = environment_radiance(reflect(-v, n), roughness);
#if PLANAR
    vec4 flat_mirror = planar_mirrored(radiance, n, roughness);
    return mix(radiance, flat_mirror.rgb, flat_mirror.a);
#else
    return radiance;
#endif
#else
    return vec3(0.0);
#endif
}

// KHR_materials_volume, "Refraction": the ray leaves where the thickness ends. From inside, through a back, it goes on in the
// air as far, or nowhere.
vec3 seen_through(MaterialParams m, vec3 n, vec3 v, vec3 p, float roughness, float thickness, float ior)
{
    vec2 own = gl_FragCoord.xy * view.size.zw;
    vec2 at = own;
    vec3 way = vec3(0.0);
    float inside = 0.0;
#if DOUBLE_SIDED
    inside = gl_FrontFacing ? 0.0 : 1.0;
#endif
    if (thickness > 0.0) {
        vec3 d = refract(-v, n, inside > 0.5 ? max(ior, 1.0) : 1.0 / max(ior, 1.0));
        if (dot(d, d) < 0.25) return reflected_inside(n, v, roughness);  // k < 0
        way = d * thickness;
#if REFRACTION > 0
        vec4 clip = view.clip_from_origin * vec4(p + way, 1.0);
        if (clip.w > 0.0) at = clamp(clip.xy / clip.w * vec2(0.5, -0.5) + 0.5, vec2(0.0), vec2(1.0));
#endif
    }
    // a body of index 1 blurs nothing, however rough; nor does the least roughness, which stands for 0
    float blur = max(roughness - MIN_ROUGHNESS, 0.0) / (1.0 - MIN_ROUGHNESS) * clamp(ior * 2.0 - 2.0, 0.0, 1.0);
    float lod = blur * float(textureQueryLevels(t_scene_color) - 1);
#if REFRACTION == 2
    float free = free_lod(at, lod);
    if (free < 0.0) {
        at = own;
        free = max(free_lod(own, lod), 0.0);
    }
    lod = least_of_quad(free);
#endif
    // its own pixel alone, without what rounding would mix in of those beside it
    bool alone = at == own && lod <= 0.0;
    vec3 light = alone ? texelFetch(t_scene_color, ivec2(gl_FragCoord.xy), 0).rgb : textureLod(t_scene_color, at, lod).rgb;
    return light * (inside > 0.5 ? vec3(1.0) : absorbed(m, length(way)));
}

vec3 light_through(MaterialParams m, Surface s, vec3 v, vec3 p, float roughness, float thickness)
{
#if DISPERSION
    // KHR_materials_dispersion: dispersion = 20 / Abbe number; the indices of red and blue lie about the middle one
    float half_spread = (m.ior - 1.0) * 0.025 * m.dispersion;
    vec3 light;
    light.r = seen_through(m, s.normal, v, p, roughness, thickness, m.ior - half_spread).r;
    light.g = seen_through(m, s.normal, v, p, roughness, thickness, m.ior).g;
    light.b = seen_through(m, s.normal, v, p, roughness, thickness, m.ior + half_spread).b;
    return light;
#else
    return seen_through(m, s.normal, v, p, roughness, thickness, m.ior);
#endif
}
