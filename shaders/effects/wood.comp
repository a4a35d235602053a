// Boards sawn along the trunk: rings are wavy lines along v, fibres are short streaks along it.
#include "lib/tiling_noise.glsl"

// Place in its year, 0 early to 1 late
float year(vec2 uv, MaterialParams m)
{
    uint seed = uint(m.seed);
    float stray = tiling_fbm(uv, ivec2(2, 1), 3, seed) + 0.35 * tiling_fbm(uv, ivec2(8, 2), 3, seed + 17u);
    return fract(uv.x * float(m.rings) + m.waves * stray);
}

// The dark line: it thickens slowly and ends at once
float late(float place)
{
    return smoothstep(0.35, 0.9, place) * (1.0 - smoothstep(0.94, 1.0, place));
}

float fibre(vec2 uv, MaterialParams m)
{
    return tiling_fbm(uv, ivec2(96, 6), 3, uint(m.seed) + 31u);
}

float height(vec2 uv, MaterialParams m)
{
    return m.relief * (0.6 * late(year(uv, m)) + 0.8 * m.fibres * min(fibre(uv, m), 0.0));
}

void main()
{
    MaterialParams m = material();
    vec2 uv = texture_uv();
    float dark = late(year(uv, m));
    float streak = fibre(uv, m);
    float shade = 1.0 + m.fibres * streak;
    shade *= 1.0 + 0.12 * tiling_fbm(uv, ivec2(3, 2), 2, uint(m.seed) + 53u);
    vec3 color = mix(m.early_wood, m.late_wood, dark) * max(shade, 0.0);
    write_base_color_map(vec4(color, 1.0));
    float rough = clamp(0.9 - 0.25 * dark - 0.2 * m.fibres * streak, 0.0, 1.0);
    write_metal_rough_map(vec4(0.0, rough, 1.0, 1.0));
    // one texel to either side; relief counts heights of about 1/200 of the texture
    vec2 texel_uv = 1.0 / vec2(texture_size());
    vec2 along_u = vec2(texel_uv.x, 0.0);
    vec2 along_v = vec2(0.0, texel_uv.y);
    float du = height(uv + along_u, m) - height(uv - along_u, m);
    float dv = height(uv + along_v, m) - height(uv - along_v, m);
    vec3 n = normalize(vec3(-vec2(du, -dv) * 0.0025 / texel_uv, 1.0));
    write_normal_map(vec4(0.5 * n + 0.5, 1.0));
}
