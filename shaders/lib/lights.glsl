// Punctual lights: directional, point, spot. The Light struct and the buffer are generated (engine/render/light_rows.py);
// the first directional ones (suns) are in the view block.
#include "lib/brdf.glsl"

// Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listings 1 and 2: inverse square with a smooth window that
// reaches zero with zero slope at the range; range 0 means unlimited. The floor under d^2 keeps a light on a surface finite;
// it is a micrometre, not their centimetre, so that a scene of millimetres is lit as the same scene in metres.
float distance_falloff(float d2, float range)
{
    float falloff = 1.0 / max(d2, 1e-12);
    if (range > 0.0) {
        float x = d2 / max(range * range, 1e-30);  // a range so small that its square is 0 would give 0/0
        float window = sat(1.0 - x * x);
        falloff *= window * window;
    }
    return falloff;
}

// The irradiance (perpendicular) that light `i` brings to point p, and the direction to it.
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

// Radiance reflected towards v of irradiance `e` (perpendicular to l) from direction l: Lambert under a GGX coat.
vec3 reflected(Reflector r, vec3 l, vec3 e)
{
    float n_dot_l = dot(r.n, l);
    if (n_dot_l <= 0.0) return vec3(0.0);
    vec3 h = safe_normalize(l + r.v);
    vec3 f = F_Schlick(r.f0, vec3(r.f90), dot(r.v, h));
    float d = D_GGX(r.alpha, sat(dot(r.n, h)), r.n, h);
    float vis = V_SmithGGXCorrelated(r.alpha, r.n_dot_v, n_dot_l);
    vec3 specular = f * min(d * vis, 1e6);
    vec3 diffuse = (1.0 - f) * r.diffuse_albedo * (1.0 / PI);
    return (specular + diffuse) * e * n_dot_l;
}

// Directional lights in the view block. `visibility`: how much of the first one arrives.
vec3 sun_lighting(Reflector r, float visibility)
{
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < view.counts.y; ++i) {
        vec3 e = view.suns[2u * i + 1u].xyz * (i == 0u ? visibility : 1.0);
        sum += reflected(r, -view.suns[2u * i].xyz, e);
    }
    return sum;
}

// All other lights.
vec3 local_lighting(vec3 p, Reflector r)
{
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < view.counts.x; ++i) {
        vec3 l;
        vec3 e = light_incidence(i, p, l);
        sum += reflected(r, l, e);
    }
    return sum;
}
