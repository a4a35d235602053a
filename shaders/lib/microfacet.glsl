// Further distributions, Fresnel and masking terms beside those of brdf.glsl. float64 twins: engine/math/microfacet.py;
// which belong together is said there too. V = G / (4 n.l n.v), so that nothing is divided by what is 0 at grazing.
#include "lib/brdf.glsl"

// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces", eq. 30, p = 2 / alpha^2 - 2. Near the
// peak (n.h)^p is taken from sin^2 by log(cos) = -1/2 (s + s^2/2 + s^3/3 ...): pow() loses its digits there.
float D_BlinnPhong(float alpha, float n_dot_h, vec3 n, vec3 h)
{
    float p = max(2.0 / max(alpha * alpha, 1e-12) - 2.0, 0.0);
    vec3 n_cross_h = cross(n, h);
    float s2 = dot(n_cross_h, n_cross_h);
    // the base is kept from 0: pow(0, 0) is 0 on some drivers
    float power = s2 < 1.0 / 16.0 && n_dot_h > 0.0 ? exp(-0.5 * p * (s2 + s2 * s2 * (0.5 + s2 * (1.0 / 3.0))))
                                                   : pow(max(n_dot_h, 1e-7), p);
    return n_dot_h > 0.0 ? (p + 2.0) * (0.5 / PI) * power : 0.0;
}

// Walter et al. 2007, eq. 25. The floor under (n.h)^2 keeps infinity times 0 away; the exponential is 0 long before.
float D_Beckmann(float alpha, float n_dot_h, vec3 n, vec3 h)
{
    vec3 n_cross_h = cross(n, h);
    float c2 = max(n_dot_h * n_dot_h, 1e-7);
    float a2 = max(alpha * alpha, 1e-12);
    float d = exp(-min(dot(n_cross_h, n_cross_h) / (a2 * c2), 80.0)) / (PI * a2 * c2 * c2);
    return n_dot_h > 0.0 && dot(n_cross_h, n_cross_h) < 80.0 * a2 * c2 ? d : 0.0;
}

// Walter et al. 2007's GGX stretched along the tangent: Burley 2012, "Physically-Based Shading at Disney", eq. 13.
// t_dot_h, b_dot_h: along tangent and bitangent.
float D_GGXAnisotropic(float alpha_t, float alpha_b, float n_dot_h, float t_dot_h, float b_dot_h)
{
    float area = alpha_t * alpha_b;
    vec3 d = vec3(alpha_b * t_dot_h, alpha_t * b_dot_h, area * n_dot_h);
    float k = area / max(dot(d, d), 1e-20);
    return area * k * k * (1.0 / PI);
}

// Heitz 2014, eq. 86 and 99, for the stretched distribution, divided by 4 n.l n.v.
float V_SmithGGXAnisotropic(
    float alpha_t, float alpha_b, float n_dot_v, float n_dot_l, vec2 across_v, vec2 across_l)
{
    vec2 a = vec2(alpha_t, alpha_b);
    float lambda_v = n_dot_l * length(vec3(a * across_v, n_dot_v));
    float lambda_l = n_dot_v * length(vec3(a * across_l, n_dot_l));
    return 0.5 / max(lambda_v + lambda_l, 1e-7);
}

// Unpolarised reflectance of a dielectric: Cook and Torrance 1982, appendix; the index from f0. An index of 1 (f0 of 0)
// reflects nothing, at grazing too.
float F_Dielectric(float f0, float v_dot_h)
{
    float c = clamp(v_dot_h, 0.0, 1.0);
    float root = sqrt(clamp(f0, 0.0, 0.9999));  // of 1 the index is infinite
    float n = (1.0 + root) / (1.0 - root);
    float g = sqrt(max(n * n - 1.0 + c * c, 0.0));
    float a = (g - c) / max(g + c, 1e-20);
    float b = ((g + c) * c - 1.0) / max((g - c) * c + 1.0, 1e-20);
    return f0 > 0.0 ? clamp(0.5 * a * a * (1.0 + b * b), 0.0, 1.0) : 0.0;
}

// Unpolarised reflectance of a metal, Born and Wolf 1999, section 14.2; its complex index from the reflectance at normal
// incidence and a tint of the edge: Gulbrandsen 2014, "Artist Friendly Metallic Fresnel", eq. 2 and 3.
float F_Conductor(float f0, float edge_tint, float v_dot_h)
{
    float c = clamp(v_dot_h, 0.0, 1.0);
    float r = clamp(f0, 0.0, 0.9999);
    float root = sqrt(r);
    float over = 1.0 + root;
    float under = (1.0 - r) / over;  // 1 - root
    // no mix(): as a + t (b - a) it gives 0 for the small index beside the large one
    float n = over / under * (1.0 - edge_tint) + (1.0 - r) / (1.0 + r) * edge_tint;
    // (r (n+1)^2 - (n-1)^2) / (1-r) as a product, which keeps its digits where r is near 1
    float k2 = max((over - n * under) * (n * over - under) / (1.0 - r), 0.0);
    float c2 = c * c;
    float s2 = 1.0 - c2;
    float t0 = n * n - k2 - s2;
    float nk = 4.0 * n * n * k2;
    float ab = sqrt(t0 * t0 + nk);
    float t1 = ab + c2;
    // ab + t0, which loses its digits where t0 is negative
    float t2 = 2.0 * c * sqrt(0.5 * (t0 < 0.0 ? nk / (ab - t0) : ab + t0));
    float across = (t1 - t2) / max(t1 + t2, 1e-20);
    float t3 = c2 * ab + s2 * s2;
    float t4 = t2 * s2;
    float along = across * (t3 - t4) / max(t3 + t4, 1e-20);
    return clamp(0.5 * (across + along), 0.0, 1.0);
}

// V-cavities: Cook and Torrance 1982, eq. 4. The floors keep it bounded at grazing, where n.l multiplies it.
float V_CookTorrance(float n_dot_v, float n_dot_l, float n_dot_h, float v_dot_h)
{
    float v = max(n_dot_v, 1e-4);
    float l = max(n_dot_l, 1e-4);
    return min(1.0, 2.0 * max(n_dot_h, 0.0) * min(v, l) / max(v_dot_h, 1e-4)) * 0.25 / (v * l);
}

// Schlick 1994, eq. 19. k: alpha / 2 beside GGX (Karis 2013), alpha sqrt(2 / pi) beside Beckmann.
float V_SmithSchlick(float k, float n_dot_v, float n_dot_l)
{
    return 0.25 / max((n_dot_v * (1.0 - k) + k) * (n_dot_l * (1.0 - k) + k), 1e-7);
}

// Walter et al. 2007, the fraction below eq. 27, for Beckmann: G1 / cosine, which is finite at grazing, and 1 at normal
// incidence, where their a is infinite.
float walter_part(float alpha, float cosine)
{
    float s = max(alpha, 1e-6) * sqrt(max(1.0 - cosine * cosine, 0.0));
    if (cosine >= 1.6 * s) return 1.0 / cosine;
    float t = cosine / s;
    return (3.535 + 2.181 * t) / (s * (1.0 + 2.276 * t + 2.577 * t * t));
}

float V_Walter(float alpha, float n_dot_v, float n_dot_l)
{
    return 0.25 * walter_part(alpha, n_dot_v) * walter_part(alpha, n_dot_l);
}
