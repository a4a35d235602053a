// Light in steps: says what effects/surface.frag leaves open under SURFACE_MODEL. No physics; the sum of several lights is
// one of stepped shares, so that each light keeps its own steps.
#include "lib/brdf.glsl"

struct Toon {
    float bands;
    float softness;
    float highlight;
    float rim;
    vec3 albedo;
};
Toon toon;

// x in [0, 1] in `bands` even steps above 0; exactly 0 at 0.
float stepped(float x)
{
    float at = sat(x) * toon.bands;
    float low = floor(at);
    float soft = max(toon.softness, 1e-4);
    return min((low + smoothstep(1.0 - soft, 1.0, at - low) + (x > 0.0 ? 1.0 : 0.0)) / (toon.bands + 1.0), 1.0);
}

vec3 model_reflected(Reflector r, vec3 l, vec3 e)
{
    float n_dot_l = dot(r.n, l);
    if (n_dot_l <= 0.0) return vec3(0.0);
    vec3 h = safe_normalize(l + r.v);
    // hard edge where GGX's lobe is at half its height
    float k = D_GGX(r.alpha, sat(dot(r.n, h)), r.n, h) * PI * r.alpha * r.alpha;
    float spot = smoothstep(0.5 - 0.5 * toon.softness, 0.5 + 0.5 * toon.softness + 1e-4, k);
    return e * (toon.albedo * (stepped(n_dot_l) / PI) + vec3(spot * toon.highlight / PI) * r.f90);
}

#if AREA_LIGHTS
// As a point in its middle, with the light that arrives there from all of it.
vec3 model_area_lighting(Light light, vec3 p, Reflector r)
{
    Reflector white = Reflector(r.n, r.v, vec3(0.0), 0.0, vec3(1.0), r.alpha, r.n_dot_v);
    vec3 lit = area_lighting(light, p, white);
    float most = max(lit.r, max(lit.g, lit.b));
    float n_dot_l = sat(dot(r.n, safe_normalize(light.position - p)));
    return most > 0.0 ? toon.albedo * lit * (stepped(n_dot_l) / max(n_dot_l, 1e-3)) : vec3(0.0);
}
#endif

Reflector model_reflector(Surface s, vec3 v)
{
    return Reflector(
        s.normal, v, vec3(0.0), 1.0, toon.albedo, s.roughness * s.roughness, max(dot(s.normal, v), 1e-4));
}

void begin_model(MaterialParams m, inout Surface s, vec3 v)
{
    toon = Toon(float(max(m.bands, 1)), m.softness, m.highlight, m.rim, s.base_color.rgb);
}

vec3 shade_model(MaterialParams m, Surface s, vec3 v, float sun)
{
    vec3 color = s.emission;
#if ENVIRONMENT
    // flat: the mean of all directions, so that only lamps make steps
    vec3 ambient = max(view.sh[0].rgb, vec3(0.0)) * (0.282095 * view.environment.z);
    float edge = 1.0 - sat(dot(s.normal, v));
    float soft = 0.5 * toon.softness;
    color += toon.albedo * ambient * s.occlusion + ambient * toon.rim * smoothstep(0.7 - soft, 0.7 + soft + 1e-4, edge);
#endif
#if SUNS
    color += sun_lighting(model_reflector(s, v), sun);
#endif
    return color;
}

vec3 finish_model(vec3 color, inout float alpha, Surface s, vec3 v) { return color; }
