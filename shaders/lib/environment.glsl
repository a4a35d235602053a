// Image-based light: irradiance from nine spherical-harmonic coefficients, specular from a cube map whose mips are
// prefiltered with GGX, and the split-sum table (Karis 2013, "Real Shading in Unreal Engine 4", pp. 4-7).
#include "lib/dfg.glsl"
#include "lib/math.glsl"

layout(binding = 8) uniform samplerCube t_environment;

#ifndef INDIRECT
#define INDIRECT 0
#endif
#if INDIRECT
// Beside the environment's light (lib/indirect.glsl): from other surfaces; what mirrors see, and how sure that is.
vec3 gathered_light = vec3(0.0);
vec4 mirrored_light = vec4(0.0);
#endif
#ifndef PLANAR
#define PLANAR 0
#endif
#if PLANAR
// Light that a flat mirror shows, over the environment's, and how far it holds; the surface shader says it.
vec4 planar_mirrored(vec3 radiance, vec3 n, float perceptual_roughness);
#endif
#ifdef AMBIENT_VISIBILITY
#if AMBIENT_VISIBILITY
#define OPEN_DIRECTION (AMBIENT_OCCLUSION & 2)
#define OCCLUSION_BOUNCES (AMBIENT_OCCLUSION & 4)
#endif
#endif
#ifndef OPEN_DIRECTION
#define OPEN_DIRECTION 0
#define OCCLUSION_BOUNCES 0
#endif
#if OPEN_DIRECTION
vec3 open_offset = vec3(0.0);  // from the normal to where the surroundings are open (lib/ambient_occlusion.glsl)
#endif

// World direction -> direction in the environment, which may be turned about +Y.
vec3 environment_direction(vec3 d_ws)
{
    float c = view.environment.x;
    float s = view.environment.y;
    return vec3(c * d_ws.x - s * d_ws.z, d_ws.y, s * d_ws.x + c * d_ws.z);
}

// Ramamoorthi and Hanrahan 2001, "An Efficient Representation for Irradiance Environment Maps", eq. 13.
// The coefficients come already multiplied with A_l and divided by pi: a uniform environment of 1 gives 1.
vec3 environment_irradiance(vec3 n_ws)
{
    vec3 n = environment_direction(n_ws);
    vec3 e = view.sh[0].rgb * 0.282095
           + view.sh[1].rgb * (0.488603 * n.y)
           + view.sh[2].rgb * (0.488603 * n.z)
           + view.sh[3].rgb * (0.488603 * n.x)
           + view.sh[4].rgb * (1.092548 * n.x * n.y)
           + view.sh[5].rgb * (1.092548 * n.y * n.z)
           + view.sh[6].rgb * (0.315392 * (3.0 * n.z * n.z - 1.0))
           + view.sh[7].rgb * (1.092548 * n.x * n.z)
           + view.sh[8].rgb * (0.546274 * (n.x * n.x - n.y * n.y));
    return max(e, vec3(0.0)) * view.environment.z;  // second-order SH of a small bright source rings below zero
}

vec3 environment_radiance(vec3 d_ws, float perceptual_roughness)
{
    float lod = perceptual_roughness * (view.environment.w - 1.0);
    return textureLod(t_environment, environment_direction(d_ws), lod).rgb * view.environment.z;
}

// How much of an even light arrives where `visible` of it does directly and the rest comes from surfaces of that albedo:
// Jimenez, Wu, Pesce, Jarabo 2016, "Practical Realtime Strategies for Accurate Indirect Occlusion", eq. 10.
vec3 visible_with_bounces(float visible, vec3 albedo)
{
    vec3 a = 2.0404 * albedo - 0.3324;
    vec3 b = -4.7951 * albedo + 0.6417;
    vec3 c = 2.7552 * albedo + 0.6903;
    return clamp(((visible * a + b) * visible + c) * visible, vec3(visible), vec3(1.0));
}

// Diffuse and specular reflection of the environment with multiple scattering.
// Fdez-Aguera 2019, "A Multiple-Scattering Microfacet Model for Real-Time Image Based Lighting", JCGT 8(1), listing 3;
// a white surface in a uniform environment returns exactly what it receives, at any roughness.
// `mirror_n`: the normal that mirrors; another one than `n` where a lobe is stretched.
vec3 environment_lighting_bent(
    vec3 n, vec3 mirror_n, vec3 v, vec3 f0, vec3 diffuse_albedo, float perceptual_roughness, float occlusion)
{
    float n_dot_v = clamp(dot(n, v), 1e-4, 1.0);
    vec2 dfg = split_sum(n_dot_v, perceptual_roughness);
    vec3 fss_ess = f0 * dfg.x + dfg.y;
    float ess = dfg.x + dfg.y;
    float ems = 1.0 - ess;
    vec3 f_avg = f0 + (1.0 - f0) / 21.0;
    vec3 fms_ems = fss_ess * f_avg / max(1.0 - f_avg * ems, 1e-4) * ems;
    vec3 k_d = diffuse_albedo * (1.0 - fss_ess - fms_ems);
#if OPEN_DIRECTION
    vec3 irradiance = environment_irradiance(safe_normalize(n + open_offset));
#else
    vec3 irradiance = environment_irradiance(n);
#endif
#if OCCLUSION_BOUNCES
    vec3 diffuse_occlusion = visible_with_bounces(occlusion, diffuse_albedo);
#else
    float diffuse_occlusion = occlusion;
#endif
    vec3 radiance = environment_radiance(reflect(-v, mirror_n), perceptual_roughness);
    // Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listing 26: occlusion of the specular lobe.
    float specular_occlusion =
        sat(pow(n_dot_v + occlusion, exp2(-16.0 * perceptual_roughness - 1.0)) - 1.0 + occlusion);
#if INDIRECT || PLANAR
    vec3 mirrored = radiance * specular_occlusion;
#if INDIRECT
    mirrored = mix(mirrored, mirrored_light.rgb, mirrored_light.a);
#endif
#if PLANAR
    vec4 flat_mirror = planar_mirrored(radiance, mirror_n, perceptual_roughness);
    mirrored = mix(mirrored, flat_mirror.rgb, flat_mirror.a);
#endif
#if INDIRECT
    return fss_ess * mirrored + (fms_ems + k_d) * (irradiance * diffuse_occlusion + gathered_light);
#else
    return fss_ess * mirrored + (fms_ems + k_d) * irradiance * diffuse_occlusion;
#endif
#else
    return fss_ess * radiance * specular_occlusion + (fms_ems + k_d) * irradiance * diffuse_occlusion;
#endif
}

vec3 environment_lighting(vec3 n, vec3 v, vec3 f0, vec3 diffuse_albedo, float perceptual_roughness, float occlusion)
{
    return environment_lighting_bent(n, n, v, f0, diffuse_albedo, perceptual_roughness, occlusion);
}
