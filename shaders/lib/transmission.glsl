// What is seen through a surface: the picture of all that is solid, and the sky, looked up where the refracted ray leaves
// the body, in a blurrier mip the rougher it is. Without thickness the wall is thin and bends nothing.
layout(binding = 24) uniform sampler2D t_scene_color;

// Beer and Lambert; attenuation_color is what is left after attenuation_distance metres (0: nothing is taken).
vec3 absorbed(MaterialParams m, float way)
{
    if (m.attenuation_distance <= 0.0) return vec3(1.0);
    return exp(log(clamp(m.attenuation_color, vec3(1e-6), vec3(1.0))) * (way / m.attenuation_distance));
}

// KHR_materials_volume, "Refraction": the ray leaves where the thickness ends.
vec3 seen_through(MaterialParams m, vec3 n, vec3 v, vec3 p, float roughness, float thickness, float ior)
{
    vec3 way = thickness > 0.0 ? refract(-v, n, 1.0 / max(ior, 1.0)) * thickness : vec3(0.0);
    vec4 clip = view.clip_from_origin * vec4(p + way, 1.0);
    vec2 at = clip.xy / max(clip.w, 1e-6) * vec2(0.5, -0.5) + 0.5;
    // a body of index 1 blurs nothing, however rough; nor does the least roughness, which stands for 0
    float blur = max(roughness - MIN_ROUGHNESS, 0.0) / (1.0 - MIN_ROUGHNESS) * clamp(ior * 2.0 - 2.0, 0.0, 1.0);
    float lod = blur * float(textureQueryLevels(t_scene_color) - 1);
    return textureLod(t_scene_color, at, lod).rgb * absorbed(m, length(way));
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
