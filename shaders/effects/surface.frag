// The standard surface: gathers the material, then adds emission, environment and punctual light (glTF 2.0, appendix B).
// what is seen through has other surroundings than the depth knows
#define AMBIENT_VISIBILITY (AMBIENT_OCCLUSION && !BLENDED)
#if defined PLANAR_MIRRORS && !defined DEEP_LAYER
#define PLANAR (PLANAR_MIRRORS && PLANAR_REFLECTION)
#endif
#include "lib/environment.glsl"
#include "lib/lights.glsl"
#include "lib/view.glsl"
#if SUN_SHADOWS
#include "lib/shadows.glsl"
#if TRANSLUCENT_SHADOWS
#include "lib/shadow_tint.glsl"
#endif
#endif
#if AMBIENT_VISIBILITY
#include "lib/ambient_occlusion.glsl"
#endif
#define INDIRECT_LIGHT (INDIRECT && !BLENDED)
#if INDIRECT_LIGHT
#include "lib/indirect.glsl"
#endif
#ifdef ALPHA_TO_COVERAGE
#include "lib/alpha_coverage.glsl"
#endif
#include "lib/skin_views.glsl"
#if VIEW_OF_SKIN
layout(location = 9) in vec3 v_skin;
#endif
#include "lib/debug_views.glsl"
// views of what a G-buffer holds
#define GBUFFER_VIEW (DEBUG_VIEW >= 9 && DEBUG_VIEW <= 12)
#if LOCAL_LIGHTS || GBUFFER || GBUFFER_VIEW || defined DEEP_LAYER
#include "lib/gbuffer.glsl"
#endif
#if LOCAL_LIGHTS
#include "lib/local_lights.glsl"
#endif

layout(location = 0) in vec3 v_position;
layout(location = 1) in vec3 v_normal;
layout(location = 2) flat in uint v_material;
#if NORMAL_MAP || HAS_TANGENT
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
#ifdef NODE_SCALE
layout(location = 10) flat in float v_scale;
#endif

#ifndef DEEP_LAYER
layout(location = 0) out vec4 o_color;
#endif
#if GBUFFER
layout(location = 1) out uvec2 o_gbuffer0;
#if GBUFFER_LAYOUT == 0
layout(location = 2) out uint o_gbuffer1;
#else
layout(location = 2) out uvec2 o_gbuffer1;
#endif
#if GBUFFER_LAYOUT == 2
layout(location = 3) out uint o_gbuffer2;
#endif
#endif

#if PLANAR
#include "lib/planar.glsl"
// the mesh's normal, for planar_mirrored
vec3 mirror_facing = vec3(0.0);

vec4 planar_mirrored(vec3 radiance, vec3 n, float perceptual_roughness)
{
    return planar_light(
        radiance, n, mirror_facing, safe_normalize(view_vector(v_position)), v_position, perceptual_roughness);
}
#endif

struct Surface {
    vec4 base_color;
    vec3 emission;
    vec3 normal;
    vec3 smooth_normal;  // without the normal map
    float metallic;
    float roughness;
    float occlusion;
};

#ifdef SURFACE_MODEL
// Another model of reflection (lib/surface_model.glsl and others like it) says these behind this file; what it keeps of
// the material in between is its own.
void begin_model(MaterialParams m, inout Surface s, vec3 v);
vec3 shade_model(MaterialParams m, Surface s, vec3 v, float sun);
Reflector model_reflector(Surface s, vec3 v);
vec3 finish_model(vec3 color, inout float alpha, Surface s, vec3 v);
#endif

vec2 first_uv()
{
#if HAS_UV0
    return v_uv0;
#else
    return vec2(0.0);
#endif
}

vec2 second_uv()
{
#if UV1
    return v_uv1;
#else
    return first_uv();
#endif
}

Surface gather(MaterialParams m)
{
    vec2 uv0 = first_uv();
    vec2 uv1 = second_uv();
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

#if INDIRECT_LIGHT
    // both tell of the same surroundings: the darker holds
#if GATHERED
    vec4 indirect = indirect_light(gl_FragCoord.xy);
#else
    vec4 indirect = vec4(0.0, 0.0, 0.0, 1.0);
#endif
    gathered_light = indirect.rgb * s.occlusion;
#if AMBIENT_VISIBILITY
    s.occlusion *= min(ambient_visibility(gl_FragCoord.xy), indirect.a);
#else
    s.occlusion *= indirect.a;
#endif
#if REFLECTIONS
    mirrored_light = reflected_light(gl_FragCoord.xy);
#endif
#elif AMBIENT_VISIBILITY
    s.occlusion *= ambient_visibility(gl_FragCoord.xy);
#endif

#if OPEN_DIRECTION
    open_offset = open_offset_at(gl_FragCoord.xy);
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
#if VIEW_LIGHTING
    s.base_color.rgb = vec3(1.0);
    s.metallic = 0.0;
    s.emission = vec3(0.0);
#endif
#if DOUBLE_SIDED
    if (!gl_FrontFacing) {
        s.normal = -s.normal;
        s.smooth_normal = -s.smooth_normal;
    }
#endif
#if PLANAR
    mirror_facing = s.smooth_normal;
#endif
    return s;
}

// How much of the first sun arrives; sets `first_sun_tint`, its colour.
float first_sun(Surface s)
{
#if SUN_SHADOWS
    vec3 facet = cross(dFdx(v_position), dFdy(v_position));
    if (view.counts.y > 0u && dot(s.normal, view.suns[0].xyz) < 0.0) {
#if TRANSLUCENT_SHADOWS
        first_sun_tint = sun_tint(v_position, s.smooth_normal, facet, uvec2(gl_FragCoord.xy));
#endif
        return sun_visibility(v_position, s.smooth_normal, facet, uvec2(gl_FragCoord.xy));
    }
#endif
    return 1.0;
}

// Reflectance at normal incidence where the surface is no metal.
vec3 dielectric_f0(MaterialParams m)
{
    float dielectric = (m.ior - 1.0) / (m.ior + 1.0);
    return min(dielectric * dielectric * m.specular_color, vec3(1.0)) * m.specular;
}

// All but the local lights.
vec3 shade(MaterialParams m, Surface s, vec3 v)
{
    vec3 f0 = mix(dielectric_f0(m), s.base_color.rgb, s.metallic);
    float f90 = mix(m.specular, 1.0, s.metallic);
    vec3 diffuse_albedo = s.base_color.rgb * (1.0 - s.metallic);
    vec3 color = s.emission;
#if ENVIRONMENT
    color += environment_lighting(s.normal, v, f0, diffuse_albedo, s.roughness, s.occlusion);
#endif
#if SUNS
    Reflector r = Reflector(s.normal, v, f0, f90, diffuse_albedo, s.roughness * s.roughness, max(dot(s.normal, v), 1e-4));
    color += sun_lighting(r, first_sun(s));
#endif
    return color;
}

#if LOCAL_LIGHTS || GBUFFER || GBUFFER_VIEW
SurfaceTexels texels_of(MaterialParams m, Surface s)
{
#if !UNLIT
    return pack_surface(s.normal, s.base_color.rgb, s.metallic, s.roughness, dielectric_f0(m), m.specular);
#else
    return pack_nothing();
#endif
}
#endif

#if LOCAL_LIGHTS && defined SURFACE_MODEL
// Nothing is packed: such a surface is never deferred, so that all paths shade it by this.
vec3 add_model_lights(vec3 color, Surface s)
{
#if MULTISAMPLED
    vec3 p = v_position;
#else
    vec3 p = position_from_depth(gl_FragCoord.xy, gl_FragCoord.z);
#endif
    Reflector r = model_reflector(s, safe_normalize(view_vector(p)));
    return add_local_lights(color, uvec2(gl_FragCoord.xy), p, r, BLENDED);
}
#elif LOCAL_LIGHTS
vec3 add_lights(vec3 color, SurfaceTexels t)
{
#if MULTISAMPLED
    vec3 p = v_position;
#else
    vec3 p = position_from_depth(gl_FragCoord.xy, gl_FragCoord.z);
#endif
    Reflector r = unpack_surface(t, safe_normalize(view_vector(p)));
    return add_local_lights(color, uvec2(gl_FragCoord.xy), p, r, BLENDED);
}
#endif

#if VIEW_OF_SURFACE
// One thing about the surface instead of its shading. Alpha: how light a quantity is drawn; with none of it, grey.
vec4 surface_view(MaterialParams m)
{
#if VIEW_DEPTH
    return vec4(vec3(view_depth(v_position)), 1.0);
#elif VIEW_OVERDRAW
    return vec4(1.0);
#elif VIEW_WIREFRAME
    return vec4(vec3(0.75), 1.0);
#elif HAS_UV0
#if UV1
    vec2 uv = m.base_color_map_uv == 1u ? v_uv1 : v_uv0;
#else
    vec2 uv = v_uv0;
#endif
#if UV_TRANSFORM
    uv = vec2(dot(m.base_color_map_row0.xyz, vec3(uv, 1.0)), dot(m.base_color_map_row1.xyz, vec3(uv, 1.0)));
#endif
#if VIEW_UV_CHECKER
    return vec4(uv_checker_view(uv), 1.0);
#elif BASE_COLOR_MAP
    vec2 density = texel_density_view(uv, vec2(textureSize(t_base_color_map, 0).xy), v_position);
    return vec4(vec3(density.x), density.y);
#elif NORMAL_MAP
    vec2 density = texel_density_view(uv, vec2(textureSize(t_normal_map, 0).xy), v_position);
    return vec4(vec3(density.x), density.y);
#elif METAL_ROUGH_MAP
    vec2 density = texel_density_view(uv, vec2(textureSize(t_metal_rough_map, 0).xy), v_position);
    return vec4(vec3(density.x), density.y);
#else
    return vec4(0.0);
#endif
#elif VIEW_OF_VALUE
    return vec4(0.0);
#else
    return vec4(vec3(0.08), 1.0);
#endif
}
#endif

#ifdef DEEP_LAYER
#include "lib/deep_layer.glsl"
#else
void main()
{
    MaterialParams m = materials[v_material];
    Surface s = gather(m);
#if ALPHA_TEST
#ifdef ALPHA_TO_COVERAGE
    gl_SampleMask[0] = alpha_coverage(s.base_color.a, m.alpha_cutoff);
    if (gl_SampleMask[0] == 0) discard;
#else
    if (s.base_color.a < m.alpha_cutoff) discard;
#endif
    s.base_color.a = 1.0;
#endif
#if UNLIT
    vec3 color = s.base_color.rgb;
#elif defined SURFACE_MODEL
    vec3 v = safe_normalize(view_vector(v_position));
    begin_model(m, s, v);
    vec3 color = shade_model(m, s, v, first_sun(s));
#else
    vec3 color = shade(m, s, safe_normalize(view_vector(v_position)));
#endif
#if LOCAL_LIGHTS && !UNLIT
#ifdef SURFACE_MODEL
    color = add_model_lights(sanitise(color), s);
#else
    color = add_lights(sanitise(color), texels_of(m, s));
#endif
#endif
#if defined SURFACE_MODEL && !UNLIT
    color = finish_model(color, s.base_color.a, s, v);
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
#elif VIEW_SHADOW_TEXELS
    vec2 seen_texels = vec2(0.0);
#if SUN_SHADOWS
    seen_texels = shadow_texels(v_position);
#endif
    color = vec3(clamp(seen_texels.x, 0.0, 32000.0));
    s.base_color.a = 1.0;
#elif DEBUG_VIEW == 21
    color = vec3(1.0);
#if AMBIENT_VISIBILITY
    color = vec3(ambient_visibility(gl_FragCoord.xy));
#endif
#elif DEBUG_VIEW >= 22 && DEBUG_VIEW <= 25
    color = vec3(0.0);
#if INDIRECT_LIGHT && GATHERED
    color = indirect_light(gl_FragCoord.xy).rgb;
#endif
#elif DEBUG_VIEW == 26
    color = vec3(0.0);
#if INDIRECT_LIGHT && REFLECTIONS
    vec4 mirrored = reflected_light(gl_FragCoord.xy);
    color = mirrored.rgb * mirrored.a;
#endif
#elif VIEW_OF_SKIN
    color = v_skin * (0.6 + 0.4 * sat(s.normal.y * 0.5 + 0.5));
#elif VIEW_OF_SURFACE
    vec4 seen_view = surface_view(m);
    color = seen_view.rgb;
    s.base_color.a = 1.0;
#elif GBUFFER_VIEW
    SurfaceTexels seen = texels_of(m, s);
    Reflector stored = unpack_surface(seen, s.normal);
    vec2 rough_red = unpackUnorm2x16(seen.a.y);
    vec3 views[4] = vec3[4](stored.n * 0.5 + 0.5, vec3(rough_red.y, unpackUnorm2x16(seen.b.x)), vec3(rough_red.x), stored.f0);
    color = views[DEBUG_VIEW - 9];
#endif
#if BLENDED
    float alpha = coverage(s.base_color.a);
    o_color = vec4(sanitise(color) * alpha, alpha);  // premultiplied
#else
    o_color = vec4(sanitise(color), 1.0);
#if VIEW_SHADOW_TEXELS
    o_color.a = seen_texels.y;
#elif VIEW_OF_VALUE
    o_color.a = seen_view.a;
#endif
#endif
#if GBUFFER
    SurfaceTexels t = texels_of(m, s);
    o_gbuffer0 = t.a;
#if GBUFFER_LAYOUT == 0
    o_gbuffer1 = t.b.x;
#else
    o_gbuffer1 = t.b;
#endif
#if GBUFFER_LAYOUT == 2
    o_gbuffer2 = t.c;
#endif
#endif
}
#endif
