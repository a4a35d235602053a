// What local lights know of a surface, packed into 12 to 20 bytes. Forward paths shade with unpack(pack(surface)) too, so
// that every path sees the same numbers. float64 twin: engine/render/gbuffer.py, which also chooses GBUFFER_LAYOUT.
//
//   word  0          1              2          3                      4
//   0     normal     roughness, r   g, b                                              dielectrics of ior 1.5: 12 bytes
//   1     normal     roughness, r   g, b       metallic, reflectance                  + metal, any ior: 16 bytes
//   2     normal     roughness, r   g, b       f0 red, f0 green       f0 blue, f90    diffuse albedo and f0: 20 bytes
#include "lib/lights.glsl"
#include "lib/octahedral.glsl"

struct SurfaceTexels {
    uvec2 a;
    uvec2 b;
    uint c;
};

SurfaceTexels pack_nothing()
{
    return SurfaceTexels(uvec2(NO_REFLECTION, 0u), uvec2(0u), 0u);
}

// base_color, metallic, roughness: as in the material; dielectric_f0 and specular: f0 and f90 where it is no metal.
SurfaceTexels pack_surface(
    vec3 n, vec3 base_color, float metallic, float roughness, vec3 dielectric_f0, float specular)
{
    SurfaceTexels t;
    vec3 c = base_color;
#if GBUFFER_LAYOUT == 2
    c = base_color * (1.0 - metallic);
    vec3 f0 = mix(dielectric_f0, base_color, metallic);
    t.b.y = packUnorm2x16(f0.rg);
    t.c = packUnorm2x16(vec2(f0.b, mix(specular, 1.0, metallic)));
#elif GBUFFER_LAYOUT == 1
    t.b.y = packUnorm2x16(vec2(metallic, dielectric_f0.r));
    t.c = 0u;
#else
    t.b.y = 0u;
    t.c = 0u;
#endif
    t.a = uvec2(packSnorm2x16(octahedral(n)), packUnorm2x16(vec2(roughness, c.r)));
    t.b.x = packUnorm2x16(c.gb);
    return t;
}

// v: unit, towards the viewer.
Reflector unpack_surface(SurfaceTexels t, vec3 v)
{
    Reflector r;
    r.v = v;
    vec2 rough_red = unpackUnorm2x16(t.a.y);
    vec3 c = vec3(rough_red.y, unpackUnorm2x16(t.b.x));
    r.alpha = rough_red.x * rough_red.x;
#if GBUFFER_LAYOUT == 2
    vec2 blue_f90 = unpackUnorm2x16(t.c);
    r.f0 = vec3(unpackUnorm2x16(t.b.y), blue_f90.x);
    r.f90 = blue_f90.y;
    r.diffuse_albedo = c;
#elif GBUFFER_LAYOUT == 1
    vec2 metallic_f0 = unpackUnorm2x16(t.b.y);
    r.f0 = mix(vec3(metallic_f0.y), c, metallic_f0.x);
    r.f90 = 1.0;
    r.diffuse_albedo = c * (1.0 - metallic_f0.x);
#else
    r.f0 = vec3(0.04);
    r.f90 = 1.0;
    r.diffuse_albedo = c;
#endif
    r.n = from_octahedral(unpackSnorm2x16(t.a.x));
    if (t.a.x == NO_REFLECTION) {
        r.n = vec3(0.0);  // no light arrives at an angle
        r.f0 = r.diffuse_albedo = vec3(0.0);
        r.f90 = 0.0;
    }
    r.n_dot_v = max(dot(r.n, v), 1e-4);
    return r;
}
