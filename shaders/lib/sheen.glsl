// Cloth: the "Charlie" sheen. Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF"; float64 twin and
// quadrature: engine/math/sheen.py.
#include "lib/math.glsl"

// Perceptual; below it the lobe is a line at the horizon.
const float MIN_SHEEN_ROUGHNESS = 0.07;

// Eq. 2.
float D_Charlie(float alpha, float n_dot_h)
{
    float power = 1.0 / max(alpha, MIN_SHEEN_ROUGHNESS * MIN_SHEEN_ROUGHNESS);
    float sine2 = clamp(1.0 - n_dot_h * n_dot_h, 1e-7, 1.0);  // the base is kept from 0: pow(0, y) may be no number
    return (2.0 + power) * pow(sine2, 0.5 * power) * (0.5 / PI);
}

// Their fit of the logarithm of Smith's lambda (section 3, table 1).
float sheen_exponent(float x, float alpha)
{
    float t = (1.0 - alpha) * (1.0 - alpha);
    float a = mix(21.5473, 25.3245, t);
    float b = mix(3.82987, 3.32435, t);
    float c = mix(0.19823, 0.16801, t);
    float d = mix(-1.97760, -1.27393, t);
    float e = mix(-4.32054, -4.85967, t);
    return a / (1.0 + b * pow(max(x, 1e-7), c)) + d * x + e;
}

float sheen_lambda(float cosine, float alpha)
{
    float c = sat(cosine);
    if (c < 0.5) return exp(sheen_exponent(c, alpha));
    return exp(2.0 * sheen_exponent(0.5, alpha) - sheen_exponent(1.0 - c, alpha));
}

// Cosines from 1e-4: n.l multiplies it.
float V_Charlie(float alpha, float n_dot_v, float n_dot_l)
{
    float a = max(alpha, MIN_SHEEN_ROUGHNESS * MIN_SHEEN_ROUGHNESS);
    float v = max(n_dot_v, 1e-4);
    float l = max(n_dot_l, 1e-4);
    return 0.25 / ((1.0 + sheen_lambda(v, a) + sheen_lambda(l, a)) * v * l);
}

// Directional albedo of the lobe, at most 1: a fit to the quadrature of engine/math/sheen.py, off by 0.0045 rms and 0.035
// at most, which is at the horizon of the smoothest cloth. Perceptual roughness.
float sheen_albedo(float n_dot_v, float roughness)
{
    float x = 1.0 - sat(n_dot_v);
    float r = sqrt(clamp(roughness, MIN_SHEEN_ROUGHNESS, 1.0));
    float a = 34.4514583 + r * (-284.8596267 + r * (659.4090199 + r * (-615.3017459 + r * 204.5179214)));
    float b = -303.1438132 + r * (1850.1481248 + r * (-3886.0639198 + r * (3466.407164 + r * -1125.473116)));
    float c = 467.7227909 + r * (-2700.1381375 + r * (5505.4554478 + r * (-4815.5071329 + r * 1541.0131456)));
    float d = -198.1948833 + r * (1139.940817 + r * (-2307.976191 + r * (2004.5737089 + r * -637.0338183)));
    return min(exp(min(a + x * (b + x * (c + x * d)), 0.0)), 1.0);
}
