// A ramp that grows lighter all along and reads without telling red from green: nine stops of viridis (van der Walt and
// Smith 2015, CC0) in sRGB. As engine/render/legends.py has it.
vec3 ramp(float x)
{
    const vec3 STOPS[9] = vec3[9](
        vec3(0.267, 0.004, 0.329), vec3(0.278, 0.177, 0.482), vec3(0.231, 0.322, 0.545), vec3(0.172, 0.447, 0.557),
        vec3(0.129, 0.569, 0.549), vec3(0.157, 0.682, 0.502), vec3(0.369, 0.788, 0.384), vec3(0.678, 0.863, 0.188),
        vec3(0.992, 0.906, 0.145));
    float at = clamp(x, 0.0, 1.0) * 8.0;
    int below = min(int(at), 7);
    vec3 c = mix(STOPS[below], STOPS[below + 1], at - float(below));
    return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), greaterThan(c, vec3(0.04045)));
}
