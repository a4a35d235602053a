vec3 combine(uint mode, vec3 a, vec3 b)
{
    return mode == 0u ? a * b : a + b;
}
