// The standard surface: gathers the material, then adds emission, environment and punctual light (glTF 2.0, appendix B).
#include "lib/environment.glsl"
#include "lib/lights.glsl"
#include "lib/view.glsl"
#if SUN_SHADOWS
#include "lib/shadows.glsl"
#endif

layout(location = 0) in vec3 v_position;
layout(location = 1) in vec3 v_normal;
layout(location = 2) flat in uint v_material;
#if NORMAL_MAP
layout(location = 3) in vec4 v_tangent;
#endif
#if HAS_UV0
layout(location = 4) in vec2 v_uv0;
#endif
#if UV1
layout(location = 5) in vec2 v_uv1;
#endif
#if VERTEX_COLOR
layout(location = 6) in vec4 v_color;
#endif

layout(location = 0) out vec4 o_color;

struct Surface {
    vec4 base_color;
    vec3 emission;
    vec3 normal;
    vec3 smooth_normal;  // without the normal map
    float metallic;
    float roughness;
    float occlusion;
};

Surface gather(MaterialParams m)
{
#if HAS_UV0
    vec2 uv0 = v_uv0;
#else
    vec2 uv0 = vec2(0.0);
#endif
#if UV1
    vec2 uv1 = v_uv1;
#else
    vec2 uv1 = uv0;
#endif
    Surface s;
    s.base_color = m.base_color;
#if BASE_COLOR_MAP
    s.base_color *= sample_base_color_map(m, uv0, uv1);
#endif
#if VERTEX_COLOR
    s.base_color *= v_color;
#endif

    s.metallic = m.metallic;
    s.roughness = m.roughness;
#if METAL_ROUGH_MAP
    vec2 rough_metal = sample_metal_rough_map(m, uv0, uv1).gb;
    s.roughness *= rough_metal.x;
    s.metallic *= rough_metal.y;
#endif
    s.roughness = clamp(s.roughness, MIN_ROUGHNESS, 1.0);

    s.occlusion = 1.0;
#if OCCLUSION_MAP
    s.occlusion = mix(1.0, sample_occlusion_map(m, uv0, uv1).r, m.occlusion_strength);
#endif

    s.emission = m.emissive * m.emissive_strength;
#if EMISSIVE_MAP
    s.emission *= sample_emissive_map(m, uv0, uv1).rgb;
#endif

    s.normal = safe_normalize(v_normal);
    vec3 smooth_normal = s.normal;
    s.roughness = antialiased_roughness(s.roughness, s.normal);
#if NORMAL_MAP
    // Mikkelsen 2008: interpolated, unnormalised tangent frame. The map holds x and y; z is rebuilt.
    vec2 xy = sample_normal_map(m, uv0, uv1).rg * 2.0 - 1.0;
    float z = sqrt(max(1.0 - dot(xy, xy), 0.0));
    vec3 tangent = safe_normalize(v_tangent.xyz);
    vec3 bitangent = cross(s.normal, tangent) * v_tangent.w;
    s.normal = safe_normalize(m.normal_scale * (xy.x * tangent + xy.y * bitangent) + z * s.normal);
#endif
    s.smooth_normal = smooth_normal;
#if DOUBLE_SIDED
    if (!gl_FrontFacing) {
        s.normal = -s.normal;
        s.smooth_normal = -s.smooth_normal;
    }
#endif
    return s;
}

// How much of the first sun arrives.
float first_sun(Surface s)
{
#if SUN_SHADOWS
    vec3 facet = cross(dFdx(v_position), dFdy(v_position));
    if (view.counts.y > 0u && dot(s.normal, view.suns[0].xyz) < 0.0)
        return sun_visibility(v_position, s.smooth_normal, facet, uvec2(gl_FragCoord.xy));
#endif
    return 1.0;
}

vec3 shade(MaterialParams m, Surface s, vec3 v)
{
    float dielectric = (m.ior - 1.0) / (m.ior + 1.0);
    vec3 f0 = min(dielectric * dielectric * m.specular_color, vec3(1.0)) * m.specular;
    f0 = mix(f0, s.base_color.rgb, s.metallic);
    float f90 = mix(m.specular, 1.0, s.metallic);
    vec3 diffuse_albedo = s.base_color.rgb * (1.0 - s.metallic);
    vec3 color = s.emission;
#if ENVIRONMENT
    color += environment_lighting(s.normal, v, f0, diffuse_albedo, s.roughness, s.occlusion);
#endif
#if SUNS || LOCAL_LIGHTS
    Reflector r = Reflector(s.normal, v, f0, f90, diffuse_albedo, s.roughness * s.roughness, max(dot(s.normal, v), 1e-4));
#endif
#if SUNS
    color += sun_lighting(r, first_sun(s));
#endif
#if LOCAL_LIGHTS
    color += local_lighting(v_position, r);
#endif
    return color;
}

void main()
{
    MaterialParams m = materials[v_material];
    Surface s = gather(m);
#if ALPHA_TEST
    if (s.base_color.a < m.alpha_cutoff) discard;
    s.base_color.a = 1.0;
#endif
#if UNLIT
    vec3 color = s.base_color.rgb;
#else
    vec3 color = shade(m, s, safe_normalize(view_vector(v_position)));
#endif
#if DEBUG_VIEW == 1
    color = s.base_color.rgb;
#elif DEBUG_VIEW == 2
    color = s.normal * 0.5 + 0.5;
#elif DEBUG_VIEW == 3
    color = vec3(s.roughness);
#elif DEBUG_VIEW == 4
    color = vec3(s.metallic);
#elif DEBUG_VIEW == 5
    color = vec3(s.occlusion);
#elif DEBUG_VIEW == 6
    color = s.emission;
#elif DEBUG_VIEW == 7
    color = vec3(0.15 + 0.75 * first_sun(s) * sat(-dot(s.normal, view.suns[0].xyz)));
#if CASCADE_TINT
    color *= cascade_tint(v_position);
#endif
#endif
#if BLENDED
    float alpha = coverage(s.base_color.a);
    o_color = vec4(sanitise(color) * alpha, alpha);  // premultiplied
#else
    o_color = vec4(sanitise(color), 1.0);
#endif
}
