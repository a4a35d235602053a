// The standard surface with other microfacet terms and further layers, each compiled in where a material's features ask for
// it: coat, sheen, anisotropy, thin film, transmission. It says what effects/surface.frag leaves open under SURFACE_MODEL.
//
//   light ─► coat ─► sheen ─► base: D, F, V (microfacet.glsl) over diffuse, or over what shines through (transmission.glsl)
// Each layer takes from those below what it reflects. Layers: KHR_materials_clearcoat, _sheen, _anisotropy, _iridescence,
// _transmission, _volume (Khronos, 2020 to 2023).
#include "lib/microfacet.glsl"
#include "lib/dfg.glsl"
#include "lib/model_features.glsl"
#if SHEEN
#include "lib/sheen.glsl"
#endif
#if IRIDESCENCE
#include "lib/thin_film.glsl"
#endif
#if TRANSMISSION
#include "lib/transmission.glsl"
#endif

// What the lights need to know of the fragment's material, beyond a Reflector.
struct Model {
    vec3 f0;
    float f90;
    vec3 f0_dielectric;
    vec3 metal;
    float metallic;
    vec3 edge_tint;
    vec3 diffuse;
    vec3 compensation;
    float roughness;
    // stretched along the tangent
    vec3 tangent;
    vec3 bitangent;
    vec2 alpha_tb;
    float strength;
    // coat
    float coat;
    float coat_roughness;
    vec3 coat_n;
    float coat_n_dot_v;
    float coat_albedo;
    float under_coat;  // what it leaves for the layers below
    // sheen
    vec3 sheen;
    float sheen_alpha;
    float under_sheen;
    // transmission
    float transmission;
    float thickness;
};
Model model;

const float COAT_F0 = 0.04;  // of index 1.5

// A unit tangent frame about n from the mesh's, turned by the material; an arbitrary one where the mesh has none.
void model_frame(vec3 n, vec2 turn)
{
#if HAS_TANGENT
    vec3 t = v_tangent.xyz - n * dot(n, v_tangent.xyz);
    float hand = v_tangent.w;
#else
    vec3 t = vec3(0.0);
    float hand = 1.0;
#endif
    if (dot(t, t) < 1e-12) t = cross(abs(n.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), n);
    t = safe_normalize(t);
    vec3 b = cross(n, t) * hand;
    model.tangent = turn.x * t + turn.y * b;
    model.bitangent = cross(n, model.tangent);
}

vec3 fresnel_exact(vec3 f0, float c) { return vec3(F_Dielectric(f0.r, c), F_Dielectric(f0.g, c), F_Dielectric(f0.b, c)); }

vec3 model_fresnel(float c)
{
#if FRESNEL_NONE
    return model.f0;
#elif FRESNEL_CONDUCTOR
    vec3 metal = vec3(F_Conductor(model.metal.r, model.edge_tint.r, c), F_Conductor(model.metal.g, model.edge_tint.g, c),
                      F_Conductor(model.metal.b, model.edge_tint.b, c));
    return mix(fresnel_exact(model.f0_dielectric, c), metal, model.metallic);
#elif FRESNEL_DIELECTRIC
    return mix(fresnel_exact(model.f0_dielectric, c), F_Schlick(model.metal, vec3(1.0), c), model.metallic);
#else
    return F_Schlick(model.f0, vec3(model.f90), c);
#endif
}

// D V of the base.
float model_lobe(Reflector r, vec3 l, vec3 h, float n_dot_l)
{
    float n_dot_h = sat(dot(r.n, h));
#if ANISOTROPY
    vec2 across_v = vec2(dot(model.tangent, r.v), dot(model.bitangent, r.v));
    vec2 across_l = vec2(dot(model.tangent, l), dot(model.bitangent, l));
    float d = D_GGXAnisotropic(
        model.alpha_tb.x, model.alpha_tb.y, n_dot_h, dot(model.tangent, h), dot(model.bitangent, h));
    return d * V_SmithGGXAnisotropic(model.alpha_tb.x, model.alpha_tb.y, r.n_dot_v, n_dot_l, across_v, across_l);
#else
#if DISTRIBUTION_BECKMANN
    float d = D_Beckmann(r.alpha, n_dot_h, r.n, h);
#elif DISTRIBUTION_BLINN_PHONG
    float d = D_BlinnPhong(r.alpha, n_dot_h, r.n, h);
#else
    float d = D_GGX(r.alpha, n_dot_h, r.n, h);
#endif
#if MASKING_SCHLICK
    float k = r.alpha * (DISTRIBUTION_BECKMANN + DISTRIBUTION_BLINN_PHONG > 0 ? 0.797884561 : 0.5);  // sqrt(2 / pi)
    return d * V_SmithSchlick(k, r.n_dot_v, n_dot_l);
#elif MASKING_WALTER
    return d * V_Walter(r.alpha, r.n_dot_v, n_dot_l);
#elif MASKING_COOK_TORRANCE
    return d * V_CookTorrance(r.n_dot_v, n_dot_l, n_dot_h, dot(r.v, h));
#elif MASKING_IMPLICIT
    return d * 0.25;
#else
    return d * V_SmithGGXCorrelated(r.alpha, r.n_dot_v, n_dot_l);
#endif
#endif
}

vec3 model_reflected(Reflector r, vec3 l, vec3 e)
{
    vec3 h = safe_normalize(l + r.v);
    float v_dot_h = dot(r.v, h);
    vec3 sum = vec3(0.0);
    float n_dot_l = dot(r.n, l);
    if (n_dot_l > 0.0) {
        vec3 f = model_fresnel(v_dot_h);
        vec3 specular = f * model.compensation * min(model_lobe(r, l, h, n_dot_l), 1e6);
        sum = (specular + (1.0 - f) * r.diffuse_albedo * (1.0 / PI)) * n_dot_l;
#if SHEEN
        float cloth = D_Charlie(model.sheen_alpha, sat(dot(r.n, h))) * V_Charlie(model.sheen_alpha, r.n_dot_v, n_dot_l);
        sum = sum * model.under_sheen + model.sheen * min(cloth, 1e4) * n_dot_l;
#endif
    }
#if CLEARCOAT
    sum *= model.under_coat;
    float coat_n_dot_l = dot(model.coat_n, l);
    if (coat_n_dot_l > 0.0) {
        float alpha = model.coat_roughness * model.coat_roughness;
        float lobe = D_GGX(alpha, sat(dot(model.coat_n, h)), model.coat_n, h)
                   * V_SmithGGXCorrelated(alpha, model.coat_n_dot_v, coat_n_dot_l);
        sum += model.coat * F_Schlick(vec3(COAT_F0), vec3(1.0), v_dot_h) * min(lobe, 1e6) * coat_n_dot_l;
    }
#endif
    return sum * e;
}

#if AREA_LIGHTS
// The base as an isotropic GGX lobe, whatever its terms are; cloth's sheen is left out.
vec3 model_area_lighting(Light light, vec3 p, Reflector r)
{
    vec3 sum = area_lighting(light, p, r);
#if SHEEN
    sum *= model.under_sheen;
#endif
#if CLEARCOAT
    float alpha = model.coat_roughness * model.coat_roughness;
    Reflector coat = Reflector(
        model.coat_n, r.v, vec3(COAT_F0 * model.coat), model.coat, vec3(0.0), alpha, max(dot(model.coat_n, r.v), 1e-4));
    sum = sum * model.under_coat + area_lighting(light, p, coat);
#endif
    return sum;
}
#endif

Reflector model_reflector(Surface s, vec3 v)
{
    return Reflector(
        s.normal, v, model.f0, model.f90, model.diffuse, model.roughness * model.roughness, max(dot(s.normal, v), 1e-4));
}

void begin_model(MaterialParams m, inout Surface s, vec3 v)
{
    vec2 uv0 = first_uv();
    vec2 uv1 = second_uv();
    float n_dot_v = clamp(dot(s.normal, v), 1e-4, 1.0);
    model.roughness = s.roughness;
#ifdef BLINN_EXPONENT
    // alpha^2 = 2 / (p + 2); roughness is its fourth root
    model.roughness = clamp(sqrt(sqrt(2.0 / (max(m.exponent, 0.0) + 2.0))), MIN_ROUGHNESS, 1.0);
#endif
    float specular = m.specular;
    vec3 tint = m.specular_color;
#if SPECULAR_MAP
    specular *= sample_specular_map(m, uv0, uv1).a;
#endif
#if SPECULAR_COLOR_MAP
    tint *= sample_specular_color_map(m, uv0, uv1).rgb;
#endif
    float plain = (m.ior - 1.0) / (m.ior + 1.0);
    model.f0_dielectric = min(plain * plain * tint, vec3(1.0)) * specular;
    model.metal = s.base_color.rgb;
    model.metallic = s.metallic;
    model.f0 = mix(model.f0_dielectric, model.metal, s.metallic);
    model.f90 = mix(specular, 1.0, s.metallic);
    model.diffuse = s.base_color.rgb * (1.0 - s.metallic);
#if FRESNEL_CONDUCTOR
    model.edge_tint = m.edge_tint;
#endif
#if IRIDESCENCE
    float film = m.iridescence;
    float part = 1.0;
#if IRIDESCENCE_MAP
    film *= sample_iridescence_map(m, uv0, uv1).r;
#endif
#if IRIDESCENCE_THICKNESS_MAP
    part = sample_iridescence_thickness_map(m, uv0, uv1).g;
#endif
    float nanometres = mix(m.iridescence_thickness_min, m.iridescence_thickness_max, part);
    vec3 seen = thin_film_fresnel(m.iridescence_ior, n_dot_v, nanometres, model.f0);
    // as a reflectance at normal incidence that Schlick makes the same of at this angle
    float x = 1.0 - n_dot_v;
    float rise = min(x * x * x * x * x, 0.9999);
    model.f0 = mix(model.f0, clamp((seen - rise) / (1.0 - rise), vec3(0.0), vec3(1.0)), film);
    model.f0_dielectric = model.f0;
    model.metal = model.f0;
#endif
    model.compensation = vec3(1.0);
#if ENERGY_COMPENSATION && !DISTRIBUTION_BECKMANN && !DISTRIBUTION_BLINN_PHONG && !FOREIGN_MASKING
    // Turquin 2019, "Practical multiple scattering compensation for microfacet models", eq. 16; the table is GGX's, with
    // its own masking, so that other pairs go without
    vec2 albedo = split_sum(n_dot_v, model.roughness);
    model.compensation = 1.0 + model.f0 * (1.0 / clamp(albedo.x + albedo.y, 0.05, 1.0) - 1.0);
#endif
#if ANISOTROPY
    float strength = m.anisotropy;
    vec2 turn = vec2(cos(m.anisotropy_rotation), sin(m.anisotropy_rotation));
#if ANISOTROPY_MAP
    vec3 along = sample_anisotropy_map(m, uv0, uv1).rgb;
    vec2 direction = along.xy * 2.0 - 1.0;
    direction = dot(direction, direction) > 1e-6 ? normalize(direction) : vec2(1.0, 0.0);
    strength *= along.z;
    turn = vec2(turn.x * direction.x - turn.y * direction.y, turn.y * direction.x + turn.x * direction.y);
#endif
    model_frame(s.normal, turn);
    float alpha = model.roughness * model.roughness;
    model.strength = strength;
    model.alpha_tb = vec2(mix(alpha, 1.0, strength * strength), alpha);
#endif
#if SHEEN
    float sheen_roughness = m.sheen_roughness;
    model.sheen = m.sheen_color;
#if SHEEN_COLOR_MAP
    model.sheen *= sample_sheen_color_map(m, uv0, uv1).rgb;
#endif
#if SHEEN_ROUGHNESS_MAP
    sheen_roughness *= sample_sheen_roughness_map(m, uv0, uv1).a;
#endif
    sheen_roughness = clamp(sheen_roughness, MIN_SHEEN_ROUGHNESS, 1.0);
    model.sheen_alpha = sheen_roughness * sheen_roughness;
    float most = max(model.sheen.r, max(model.sheen.g, model.sheen.b));
    model.under_sheen = 1.0 - most * sheen_albedo(n_dot_v, sheen_roughness);
#endif
#if CLEARCOAT
    model.coat = m.clearcoat;
    model.coat_roughness = m.clearcoat_roughness;
#if CLEARCOAT_MAP
    model.coat *= sample_clearcoat_map(m, uv0, uv1).r;
#endif
#if CLEARCOAT_ROUGHNESS_MAP
    model.coat_roughness *= sample_clearcoat_roughness_map(m, uv0, uv1).g;
#endif
    model.coat_roughness = antialiased_roughness(clamp(model.coat_roughness, MIN_ROUGHNESS, 1.0), s.smooth_normal);
    model.coat_n = s.smooth_normal;
#if CLEARCOAT_NORMAL_MAP
    vec2 xy = sample_clearcoat_normal_map(m, uv0, uv1).rg * 2.0 - 1.0;
    float z = sqrt(max(1.0 - dot(xy, xy), 0.0));
    vec3 coat_t = safe_normalize(v_tangent.xyz);
    vec3 coat_b = cross(s.smooth_normal, coat_t) * v_tangent.w;
    model.coat_n = safe_normalize(m.clearcoat_normal_scale * (xy.x * coat_t + xy.y * coat_b) + z * s.smooth_normal);
#endif
    model.coat_n_dot_v = clamp(dot(model.coat_n, v), 1e-4, 1.0);
    // its albedo, not its Fresnel at this angle as KHR_materials_clearcoat has it: so base and coat sum to 1 when rough, too
    vec2 coat_albedo = split_sum(model.coat_n_dot_v, model.coat_roughness);
    model.coat_albedo = model.coat * (COAT_F0 * coat_albedo.x + coat_albedo.y);
    model.under_coat = 1.0 - model.coat_albedo;
#endif
#if TRANSMISSION
    model.transmission = m.transmission;
    model.thickness = m.thickness * v_scale;
#if TRANSMISSION_MAP
    model.transmission *= sample_transmission_map(m, uv0, uv1).r;
#endif
#if THICKNESS_MAP
    model.thickness *= sample_thickness_map(m, uv0, uv1).g;
#endif
    model.diffuse *= 1.0 - model.transmission;
#endif
}

vec3 shade_model(MaterialParams m, Surface s, vec3 v, float sun)
{
    Reflector r = model_reflector(s, v);
    vec3 below = vec3(0.0);
    vec3 above = vec3(0.0);  // sheen and coat in the light of the environment
#if ENVIRONMENT
    vec3 mirror_n = s.normal;
#if ANISOTROPY
    // bent towards the plane across the grain (KHR_materials_anisotropy, "Image-based lighting")
    vec3 across = cross(cross(model.bitangent, v), model.bitangent);
    float bend = 1.0 - model.strength * (1.0 - model.roughness);
    mirror_n = safe_normalize(mix(safe_normalize(across), s.normal, bend * bend * bend * bend));
#endif
    below = environment_lighting_bent(s.normal, mirror_n, v, model.f0, model.diffuse, model.roughness, s.occlusion);
#if SHEEN
    float cloth = sheen_albedo(r.n_dot_v, sqrt(model.sheen_alpha));
    vec3 cloth_light = environment_radiance(reflect(-v, s.normal), sqrt(model.sheen_alpha));
    below = below * model.under_sheen + model.sheen * cloth * cloth_light * s.occlusion;
#endif
#if CLEARCOAT
    vec3 on_coat = environment_radiance(reflect(-v, model.coat_n), model.coat_roughness);
#if PLANAR
    vec4 flat_coat = planar_mirrored(on_coat, model.coat_n, model.coat_roughness);
    above = mix(on_coat * (model.coat_albedo * s.occlusion), flat_coat.rgb * model.coat_albedo, flat_coat.a);
#else
    above = on_coat * (model.coat_albedo * s.occlusion);
#endif
#endif
#endif
    below += s.emission;
#if TRANSMISSION
    vec2 albedo = split_sum(r.n_dot_v, model.roughness);
    vec3 let_in = 1.0 - (model.f0_dielectric * albedo.x + model.f90 * albedo.y);
    float clear = model.transmission * (1.0 - s.metallic);
    below += clear * let_in * s.base_color.rgb * light_through(m, s, v, v_position, model.roughness, model.thickness);
#endif
#if CLEARCOAT
    vec3 color = below * model.under_coat + above;
#else
    vec3 color = below + above;
#endif
#if SUNS
    color += sun_lighting(r, sun);
#endif
    return color;
}

vec3 finish_model(vec3 color, inout float alpha, Surface s, vec3 v)
{
#ifdef SOLID
    alpha = 1.0;
#endif
    return color;
}
