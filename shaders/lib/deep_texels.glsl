// Two words each of a layer's two textures: normal; diffuse albedo and roughness; emission. 16 bytes a texel.
struct DeepSurface {
    vec3 n;  // unit, 0 where it is not known
    vec3 albedo;
    float roughness;
    vec3 emission;
};

// GL_EXT_texture_shared_exponent, "Additional Restrictions and Format Conversions": 9 bits a channel, 5 of exponent.
uint pack_shared_exponent(vec3 c)
{
    vec3 kept = vec3(c.r > 0.0 ? min(c.r, 65408.0) : 0.0, c.g > 0.0 ? min(c.g, 65408.0) : 0.0,
                     c.b > 0.0 ? min(c.b, 65408.0) : 0.0);
    float most = max(kept.r, max(kept.g, kept.b));
    if (!(most > 0.0)) return 0u;
    float exponent = clamp(floor(log2(most)), -16.0, 15.0) + 1.0;
    if (floor(most * exp2(9.0 - exponent) + 0.5) > 511.0) exponent += 1.0;
    uvec3 whole = uvec3(min(floor(kept * exp2(9.0 - exponent) + 0.5), vec3(511.0)));
    return whole.r | whole.g << 9u | whole.b << 18u | uint(exponent + 15.0) << 27u;
}

vec3 unpack_shared_exponent(uint word)
{
    vec3 whole = vec3(float(word & 511u), float(word >> 9u & 511u), float(word >> 18u & 511u));
    return whole * exp2(float(word >> 27u) - 24.0);
}
