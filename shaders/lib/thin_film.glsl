// Iridescence: a thin film on a surface. Belcour and Barla 2017, "A Practical Extension to Microfacet Theory for the
// Modeling of Varying Iridescence", as KHR_materials_iridescence takes it. float64 twin: engine/math/thin_film.py.
#include "lib/math.glsl"

// Their sensitivity to a phase (optical path over wavelengths): Gaussians in the Fourier domain; metres. To linear Rec. 709.
vec3 film_sensitivity(float path, vec3 shift)
{
    float phase = 2.0 * PI * path;
    vec3 height = vec3(5.4856e-13, 4.4201e-13, 5.2481e-13);
    vec3 place = vec3(1.6810e+06, 1.7953e+06, 2.2084e+06);
    vec3 width = vec3(4.3278e+09, 9.3046e+09, 6.6121e+09);
    vec3 xyz = height * sqrt(2.0 * PI * width) * cos(place * phase + shift) * exp(-width * phase * phase);
    xyz.x += 9.7470e-14 * sqrt(2.0 * PI * 4.5282e+09) * cos(2.2399e+06 * phase + shift.x)
           * exp(-4.5282e+09 * phase * phase);
    xyz /= 1.0685e-7;
    const mat3 rec709_from_xyz =
        mat3(3.2404542, -0.9692660, 0.0556434, -1.5371385, 1.8760108, -0.2040259, -0.4985314, 0.0415560, 1.0572252);
    return rec709_from_xyz * xyz;
}

vec3 schlick_of_film(vec3 f0, float c)
{
    float x = 1.0 - sat(c);
    float x2 = x * x;
    return f0 + (1.0 - f0) * (x2 * x2 * x);
}

// Reflectance in air of a film of index `film_ior` and thickness (nanometres) over a base that reflects base_f0 in air.
vec3 thin_film_fresnel(float film_ior, float n_dot_v, float thickness, vec3 base_f0)
{
    float ior = film_ior;
    float c1 = sat(n_dot_v);
    float sine2 = (1.0 - c1 * c1) / (ior * ior);
    float c2_squared = 1.0 - sine2;
    if (c2_squared < 0.0) return vec3(1.0);
    float c2 = sqrt(c2_squared);

    float r0 = (ior - 1.0) / (ior + 1.0);
    float r12 = schlick_of_film(vec3(r0 * r0), c1).x;
    float t121 = 1.0 - r12;
    float phi12 = ior < 1.0 ? PI : 0.0;
    float phi21 = PI - phi12;

    vec3 root = sqrt(clamp(base_f0, vec3(0.0), vec3(0.9999)));
    vec3 base_ior = (1.0 + root) / (1.0 - root);
    vec3 r1 = (base_ior - ior) / (base_ior + ior);
    vec3 r23 = schlick_of_film(r1 * r1, c2);
    vec3 phi23 = mix(vec3(0.0), vec3(PI), lessThan(base_ior, vec3(ior)));

    float path = 2.0 * ior * thickness * 1e-9 * c2;
    vec3 shift = vec3(phi21) + phi23;
    vec3 r123 = clamp(r12 * r23, vec3(1e-5), vec3(0.9999));
    vec3 r123_root = sqrt(r123);
    vec3 rs = t121 * t121 * r23 / (vec3(1.0) - r123);
    vec3 sum = r12 + rs;
    vec3 c = rs - t121;
    for (int m = 1; m <= 2; ++m) {
        c *= r123_root;
        sum += 2.0 * c * film_sensitivity(float(m) * path, float(m) * shift);
    }
    // Schlick's form at two faces is not that of one: below 10 nm, where no film is seen, it goes over into the bare base
    sum = mix(schlick_of_film(base_f0, c1), sum, smoothstep(0.0, 10.0, thickness));
    return clamp(sum, vec3(0.0), vec3(1.0));  // the Gaussians leave the gamut of the display
}
