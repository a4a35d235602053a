// Punctual lights: directional, point, spot. The Light struct and the buffer are generated (engine/render/light_rows.py).
#include "lib/brdf.glsl"

// Lagarde and de Rousiers 2014, "Moving Frostbite to PBR", listings 1 and 2: inverse square with a smooth window that
// reaches zero with zero slope at the range; range 0 means unlimited. The floor under d^2 keeps a light on a surface finite.
float distance_falloff(float d2, float range)
{
    float falloff = 1.0 / max(d2, 1e-4);
    if (range > 0.0) {
        float x = d2 / (range * range);
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

vec3 punctual_lighting(vec3 p, vec3 n, vec3 v, vec3 f0, float f90, vec3 diffuse_albedo, float alpha)
{
    float n_dot_v = max(dot(n, v), 1e-4);
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < view.counts.x; ++i) {
        vec3 l;
        vec3 e = light_incidence(i, p, l);
        float n_dot_l = dot(n, l);
        if (n_dot_l <= 0.0) continue;
        vec3 h = safe_normalize(l + v);
        float n_dot_h = sat(dot(n, h));
        vec3 f = F_Schlick(f0, vec3(f90), dot(v, h));
        float d = D_GGX(alpha, n_dot_h, n, h);
        float vis = V_SmithGGXCorrelated(alpha, n_dot_v, n_dot_l);
        vec3 specular = f * min(d * vis, 1e6);
        vec3 diffuse = (1.0 - f) * diffuse_albedo * (1.0 / PI);
        sum += (specular + diffuse) * e * n_dot_l;
    }
    return sum;
}
