// Noise over texture coordinates that repeats: what is at 0 is at 1.

// pcg2d of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering"
uvec2 hash(uvec2 v)
{
    v = v * 1664525u + 1013904223u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    v ^= v >> 16u;
    v.x += v.y * 1664525u;
    v.y += v.x * 1664525u;
    return v ^ (v >> 16u);
}

// -1 to 1; `cells` of the lattice in one turn of the texture coordinates
float tiling_noise(vec2 uv, ivec2 cells, uint seed)
{
    vec2 p = uv * vec2(cells);
    ivec2 corner = ivec2(floor(p));
    vec2 f = p - floor(p);
    vec2 w = f * f * f * (f * (f * 6.0 - 15.0) + 10.0);
    vec4 at;
    for (int i = 0; i < 4; ++i) {
        ivec2 lattice = corner + ivec2(i & 1, i >> 1);
        lattice = ((lattice % cells) + cells) % cells;
        uint bits = hash(uvec2(lattice) + uvec2(seed * 7919u, seed * 104729u)).x;
        at[i] = float(bits >> 8u) * (2.0 / 16777215.0) - 1.0;
    }
    return mix(mix(at.x, at.y, w.x), mix(at.z, at.w, w.x), w.y);
}

// Of `octaves`, each with twice the cells and half the height; about -1 to 1
float tiling_fbm(vec2 uv, ivec2 cells, int octaves, uint seed)
{
    float sum = 0.0;
    float height = 0.5;
    for (int i = 0; i < octaves; ++i) {
        sum += height * tiling_noise(uv, cells, seed + uint(i));
        cells *= 2;
        height *= 0.5;
    }
    return sum;
}
