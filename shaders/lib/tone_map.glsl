// Scene-linear Rec.709 -> display-linear Rec.709 in [0,1]. float64 twins: engine/math/tonemap.py.

// Khronos PBR Neutral Tone Mapper specification (2024): identity but for the Fresnel offset below the compression start.
vec3 tone_map_neutral(vec3 c)
{
    const float start_compression = 0.8 - 0.04;
    const float desaturation = 0.15;
    float x = min(c.r, min(c.g, c.b));
    float offset = x < 0.08 ? x - 6.25 * x * x : 0.04;
    c -= offset;
    float peak = max(c.r, max(c.g, c.b));
    if (peak < start_compression) return c;
    float d = 1.0 - start_compression;
    float new_peak = 1.0 - d * d / (peak + d - start_compression);
    c *= new_peak / peak;
    float g = 1.0 - 1.0 / (desaturation * (peak - new_peak) + 1.0);
    return mix(c, vec3(new_peak), g);
}

// Stephen Hill 2016, fit of the ACES RRT and sRGB ODT (sRGB -> AP1 with RRT saturation, curve, back).
vec3 tone_map_aces(vec3 c)
{
    const mat3 input_m = mat3(0.59719, 0.07600, 0.02840, 0.35458, 0.90834, 0.13383, 0.04823, 0.01566, 0.83777);
    const mat3 output_m = mat3(1.60475, -0.10208, -0.00327, -0.53108, 1.10813, -0.07276, -0.07367, -0.00605, 1.07602);
    vec3 v = input_m * c;
    vec3 a = v * (v + 0.0245786) - 0.000090537;
    vec3 b = v * (0.983729 * v + 0.4329510) + 0.238081;
    return clamp(output_m * (a / b), 0.0, 1.0);
}

// AgX (Troy Sobotka 2022), with the sixth-order fit of its default contrast curve by Benjamin Wrensch (2023).
// The curve's output is display-encoded with a 2.2 power, so it is decoded here.
vec3 tone_map_agx(vec3 c)
{
    const mat3 inset = mat3(0.842479062253094, 0.0423282422610123, 0.0423756549057051,
                            0.0784335999999992, 0.878468636469772, 0.0784336,
                            0.0792237451477643, 0.0791661274605434, 0.879142973793104);
    const mat3 outset = mat3(1.19687900512017, -0.0528968517574562, -0.0529716355144438,
                             -0.0980208811401368, 1.15190312990417, -0.0980434501171241,
                             -0.0990297440797205, -0.0989611768448433, 1.15107367264116);
    const float min_ev = -12.47393;
    const float max_ev = 4.026069;
    vec3 v = inset * c;
    v = clamp((log2(max(v, 1e-10)) - min_ev) / (max_ev - min_ev), 0.0, 1.0);
    vec3 v2 = v * v;
    vec3 v4 = v2 * v2;
    v = 15.5 * v4 * v2 - 40.14 * v4 * v + 31.96 * v4 - 6.868 * v2 * v + 0.4298 * v2 + 0.1191 * v - 0.00232;
    v = outset * v;
    return pow(clamp(v, 0.0, 1.0), vec3(2.2));
}
