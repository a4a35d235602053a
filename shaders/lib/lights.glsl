// Lights: directional, point, spot; area lights in area_lights.glsl. The Light struct and the buffer are generated (engine/render/light_rows.py);
// the first directional ones (suns) are in the view block.
#include "lib/brdf.glsl"
#include "lib/steps.glsl"

// Both are 0 where the scene has none; a shader that does not say is right for every scene.
#ifndef AREA_LIGHTS
#define AREA_LIGHTS 1
#endif
#ifndef LIGHT_PROFILES
#define LIGHT_PROFILES 1
#endif

#ifndef TRANSLUCENT_SHADOWS
#define TRANSLUCENT_SHADOWS 0
#endif
#if TRANSLUCENT_SHADOWS
vec3 first_sun_tint = vec3(1.0);  // what blended casters leave of the first sun (lib/shadow_tint.glsl)
#endif

// Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listings 1 and 2: a smooth window that reaches zero with zero
// slope at the range; range 0 means unlimited.
float range_window(float d2, float range)
{
    if (range <= 0.0) return 1.0;
    float x = d2 / max(range * range, 1e-30);  // a range so small that its square is 0 would give 0/0
    float window = sat(1.0 - x * x);
    return window * window;
}

// Inverse square in that window. The floor under d^2 keeps a light on a surface finite; it is a micrometre, not their
// centimetre, so that a scene of millimetres is lit as the same scene in metres.
float distance_falloff(float d2, float range)
{
    return range_window(d2, range) / max(d2, 1e-12);
}

#if LIGHT_PROFILES
// IES profiles over their brightest direction: x from 0 to 360 degrees around, y from 0 (where the light shines) to 180.
layout(binding = 14) uniform sampler2DArray t_profiles;

float light_profile(Light light, vec3 from_light)
{
    if (light.profile < 0) return 1.0;
    vec3 up = cross(light.right, light.direction);
    vec2 around = vec2(dot(from_light, light.right), dot(from_light, up));
    // straight ahead and back there is no angle around, and atan(0, 0) is undefined
    float turn = dot(around, around) > 1e-12 ? atan(around.y, around.x) / (2.0 * PI) : 0.0;
    float down = acos(clamp(dot(from_light, light.direction), -1.0, 1.0)) / PI;
    vec2 size = vec2(textureSize(t_profiles, 0).xy);
    vec2 at = (vec2(fract(turn), down) * (size - 1.0) + 0.5) / size;  // texels at 0 and at 1
    return textureLod(t_profiles, vec3(at, float(light.profile)), 0.0).r;
}
#endif

// The irradiance (perpendicular) that punctual light `i` brings to point p, and the direction to it.
vec3 light_incidence(uint i, vec3 p, out vec3 l)
{
    Light light = lights[i];
    l = -light.direction;
    if (light.type == 0u) return light.color;
    vec3 to_light = light.position - p;
    float d2 = dot(to_light, to_light);
    l = safe_normalize(to_light);
    float e = distance_falloff(d2, light.range);
    if (light.type == 2u) {
        // KHR_lights_punctual, "Inner and Outer Cone Angles"
        float cone = sat(dot(-l, light.direction) * light.spot_scale + light.spot_offset);
        e *= cone * cone;
    }
#if LIGHT_PROFILES
    e *= light_profile(light, -l);
#endif
    return light.color * e;
}

// What a surface point is to a light: unit normal and direction to the viewer, reflectances, GGX alpha, n.v.
struct Reflector {
    vec3 n;
    vec3 v;
    vec3 f0;
    float f90;
    vec3 diffuse_albedo;
    float alpha;
    float n_dot_v;
};

#ifdef SURFACE_MODEL
// Another model of reflection, which says these (see effects/surface.frag).
vec3 model_reflected(Reflector r, vec3 l, vec3 e);
vec3 model_area_lighting(Light light, vec3 p, Reflector r);
#endif

// Radiance reflected towards v of irradiance `e` (perpendicular to l) from direction l: Lambert under a GGX coat.
vec3 reflected(Reflector r, vec3 l, vec3 e)
{
#ifdef SURFACE_MODEL
    return model_reflected(r, l, e);
#else
    float n_dot_l = dot(r.n, l);
    if (n_dot_l <= 0.0) return vec3(0.0);
    vec3 h = safe_normalize(l + r.v);
    vec3 f = F_Schlick(r.f0, vec3(r.f90), dot(r.v, h));
    float d = D_GGX(r.alpha, sat(dot(r.n, h)), r.n, h);
    float vis = V_SmithGGXCorrelated(r.alpha, r.n_dot_v, n_dot_l);
    vec3 specular = f * min(d * vis, 1e6);
    vec3 diffuse = (1.0 - f) * r.diffuse_albedo * (1.0 / PI);
    return (specular + diffuse) * e * n_dot_l;
#endif
}

// Directional lights in the view block. `visibility`: how much of the first one arrives.
vec3 sun_lighting(Reflector r, float visibility)
{
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < view.counts.y; ++i) {
        vec3 e = view.suns[2u * i + 1u].xyz * (i == 0u ? visibility : 1.0);
#if TRANSLUCENT_SHADOWS
        if (i == 0u) e *= first_sun_tint;
#endif
        sum += reflected(r, -view.suns[2u * i].xyz, e);
    }
    return sum;
}

#if AREA_LIGHTS
#include "lib/area_lights.glsl"
#endif

// Radiance towards r.v that the surface at p reflects of light `i`; exactly 0 beyond its reach (LightRows.bounds).
vec3 light_contribution(uint i, vec3 p, Reflector r)
{
#if AREA_LIGHTS && defined SURFACE_MODEL
    if (lights[i].type >= 3u) return model_area_lighting(lights[i], p, r);
#elif AREA_LIGHTS
    if (lights[i].type >= 3u) return area_lighting(lights[i], p, r);
#endif
    vec3 l;
    vec3 e = light_incidence(i, p, l);
    return reflected(r, l, e);
}

// All other lights, in the order of the buffer: the sum has the same bits wherever it is made in this order.
vec3 local_lighting(vec3 p, Reflector r)
{
    vec3 sum = vec3(0.0);
#define ADD_CONTRIBUTION(j) if (i + j < view.counts.x) sum += light_contribution(i + j, p, r);
    for (uint i = 0u; i < view.counts.x; i += STEPS) { REPEAT(ADD_CONTRIBUTION) }
#undef ADD_CONTRIBUTION
    return sum;
}
