// The nearest half float, as a float: so that no store to a 16-bit texture cuts digits off, which drivers may, and which
// would darken with every pass. Below 2^-14 the store still rounds as it likes, by less than 6e-8.
vec3 nearest_half(vec3 c)
{
    return uintBitsToFloat((floatBitsToUint(c) + 0x1000u) & 0xffffe000u);
}
