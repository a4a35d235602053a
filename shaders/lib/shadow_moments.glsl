// Shadow maps that can be blurred: what a texel keeps of depth, and how much light the blurred numbers leave.
// Formulas, sources and float64 twins: engine/render/shadows/moments.py. z: -1 towards the light, 1 away from it.
//   SHADOW_FILTER 8 esm, 9 vsm, 10 evsm2, 11 evsm4, 12 msm; SHADOW_HALF: kept in half floats
#if SHADOW_HALF
const float MOMENT_ROUNDING = 2e-3;
const float MOMENT_BIAS = 2e-3;
#else
const float MOMENT_ROUNDING = 1e-6;
const float MOMENT_BIAS = 3e-7;
#endif
const vec4 MOMENT_BIAS_TOWARDS = vec4(0.0, 0.375, 0.0, 0.375);

vec4 moments_of(float z, float c)
{
#if SHADOW_FILTER == 8
    return vec4(exp(c * (z - 1.0)), 0.0, 0.0, 0.0);
#elif SHADOW_FILTER == 9
    return vec4(z, z * z, 0.0, 0.0);
#elif SHADOW_FILTER == 12
    float s = z * z;
    return vec4(z, s, s * z, s * s);
#else
    float up = exp(c * z);
#if SHADOW_FILTER == 11
    float down = -exp(-c * z);
    return vec4(up, up * up, down, down * down);
#else
    return vec4(up, up * up, 0.0, 0.0);
#endif
#endif
}

float chebyshev(vec2 m, float t, float least)
{
    float off = t - m.x;
    if (off <= 0.0) return 1.0;
    float variance = max(m.y - m.x * m.x, least);
    return variance / (variance + off * off);
}

float hamburger(vec4 m, float t)
{
    vec4 b = m + (MOMENT_BIAS_TOWARDS - m) * MOMENT_BIAS;
    float d11 = b.y - b.x * b.x;
    float off3 = b.z - b.x * b.y;
    float l21 = off3 / d11;
    float d22 = (b.w - b.y * b.y) - l21 * off3;
    float c2 = ((t * t - b.y) - l21 * (t - b.x)) / d22;
    float c1 = (t - b.x) / d11 - l21 * c2;
    float c0 = 1.0 - b.x * c1 - b.y * c2;
    float p = c1 / c2;
    float root = sqrt(max(0.25 * p * p - c0 / c2, 0.0));
    float low = -0.5 * p - root;
    float high = -0.5 * p + root;
    if (!(t > low)) return 1.0;
    float before = t > high ? 1.0 - (b.y - (low + high) * b.x + low * high) / ((t - low) * (t - high))
                            : (b.y - (t + high) * b.x + t * high) / ((low - t) * (low - high));
    return before > 0.0 ? 1.0 - min(before, 1.0) : 1.0;  // also where it is not a number
}

// t: depth of the receiver; c: exponent; leak: of the light, what is none; texel: its width in the unit of depth; steep:
// the receiver's depth per texel, times the square of the blur's radius in texels.
float moment_visibility(vec4 m, float t, float c, float leak, float texel, float steep)
{
#if SHADOW_FILTER == 8
    float p = min(m.x * exp(c * (1.0 - t)), 1.0);
#elif SHADOW_FILTER == 9
    float p = chebyshev(m.xy, t, max(MOMENT_ROUNDING, 0.0625 * texel * texel));
#elif SHADOW_FILTER == 12
    float p = hamburger(m, t);
#else
    float least = max(MOMENT_ROUNDING, 0.0625 * texel * texel * c * c);
    float up = exp(c * t);
    float p = chebyshev(m.xy, up, least * up * up);
#if SHADOW_FILTER == 11
    float down = -exp(-c * t);
    // the mean of a convex function over a slope lies beyond the receiver: no bound of what others hide
    p = min(p, max(chebyshev(m.zw, down, least * down * down), clamp(c * steep * 0.25 - 1.0, 0.0, 1.0)));
#endif
#endif
    return clamp((p - leak) / (1.0 - leak), 0.0, 1.0);
}
