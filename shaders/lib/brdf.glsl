// Microfacet BRDF terms. float64 twins: engine/math/ggx.py.
#include "lib/math.glsl"

// Below this perceptual roughness the fp32 GGX lobe is under-resolved (Lagarde and de Rousiers 2014 use 0.045).
const float MIN_ROUGHNESS = 0.045;

#ifdef STAGE_FRAGMENT  // derivatives are there only
#ifdef STAGE_FRAGMENT
// Tokuyoshi and Kaplanyan 2019, "Improved Geometric Specular Antialiasing", eqs. 4 to 6: how far the normal turns within
// a pixel widens the lobe, so that thin bevels and far curved metal do not sparkle. Perceptual roughness in and out.
float antialiased_roughness(float perceptual_roughness, vec3 n)
{
    const float variance_of_pixel = 0.25;  // (half a pixel)^2
    const float most = 0.18;               // their threshold: a whole lobe must not become diffuse
    vec3 du = dFdx(n);
    vec3 dv = dFdy(n);
    float widening = 2.0 * variance_of_pixel * (dot(du, du) + dot(dv, dv));
    widening = widening < most ? widening : most;  // also where a neighbour's normal is not a number
    float alpha = perceptual_roughness * perceptual_roughness;
    return sqrt(sqrt(sat(alpha * alpha + widening)));
}
#endif
#endif

// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 33 (GGX), with 1-(n.h)^2 taken as
// |n x h|^2 (Lagrange's identity), which keeps its digits when alpha is small and n.h is near 1.
float D_GGX(float alpha, float n_dot_h, vec3 n, vec3 h)
{
    vec3 n_cross_h = cross(n, h);
    float a = n_dot_h * alpha;
    float k = alpha / max(dot(n_cross_h, n_cross_h) + a * a, 1e-20);
    return k * k * (1.0 / PI);
}

// Heitz 2014, "Understanding the Masking-Shadowing Function", eq. 99: height-correlated Smith, divided by 4 n.l n.v.
float V_SmithGGXCorrelated(float alpha, float n_dot_v, float n_dot_l)
{
    float a2 = alpha * alpha;
    float lambda_v = n_dot_l * sqrt(n_dot_v * n_dot_v * (1.0 - a2) + a2);
    float lambda_l = n_dot_v * sqrt(n_dot_l * n_dot_l * (1.0 - a2) + a2);
    return 0.5 / max(lambda_v + lambda_l, 1e-7);  // both zero only at grazing view and light
}

// Schlick 1994, "An Inexpensive BRDF Model", eq. 15. v.h outside [0,1] by rounding would leave [f0, f90].
vec3 F_Schlick(vec3 f0, vec3 f90, float v_dot_h)
{
    float x = 1.0 - clamp(v_dot_h, 0.0, 1.0);
    float x2 = x * x;
    return f0 + (f90 - f0) * (x2 * x2 * x);
}
