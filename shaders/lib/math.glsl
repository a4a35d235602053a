// Small numeric helpers. Each clamp says why.

const float PI = 3.14159265358979;

// Saturate.
float sat(float x) { return clamp(x, 0.0, 1.0); }

// Coverage of a surface or pixel in [0, 1], 0 where it is not a number: a compare, as in sanitise. One that is beyond
// would blend what lies behind with a negative weight.
float coverage(float a) { return a > 0.0 ? min(a, 1.0) : 0.0; }

// normalize() of a zero vector is NaN at run time; this gives zero instead.
vec3 safe_normalize(vec3 v) { return v * inversesqrt(max(dot(v, v), 1e-30)); }

// The last step of every lighting output: NaN, Inf and negatives stay one pixel and do not spread.
// A compare, not min/max: their order with NaN is undefined.
vec3 sanitise(vec3 c)
{
    return vec3(c.r > 0.0 ? min(c.r, 32000.0) : 0.0,
                c.g > 0.0 ? min(c.g, 32000.0) : 0.0,
                c.b > 0.0 ? min(c.b, 32000.0) : 0.0);
}
