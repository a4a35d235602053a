// Colours as TAA mixes them: a sample counts by what a display makes of it, so that one bright sample among many does not
// leave a stairway (after Karis 2014, "High-Quality Temporal Supersampling"). Up to KNEE the largest channel stays as it is,
// so that edges of what is not bright are mixed as light; above it approaches 1.
const float KNEE = 0.75;

vec3 compressed(vec3 c)
{
    c *= taa.exposure;
    float m = max(c.r, max(c.g, c.b));
    if (m <= KNEE) return c;
    float x = (m - KNEE) / (1.0 - KNEE);
    return c * ((KNEE + (1.0 - KNEE) * x / (1.0 + x)) / m);
}

vec3 expanded(vec3 c)
{
    float m = max(c.r, max(c.g, c.b));
    // below 1 by what float32 can tell, so that the brightest stays finite
    float x = (m - KNEE) / max(1.0 - m, 1e-6);
    // no brighter than what is sanitised may be
    return min(c * ((m <= KNEE ? 1.0 : (KNEE + (1.0 - KNEE) * x) / m) / taa.exposure), vec3(32000.0));
}

// Luma and two differences of colour (Malvar, Sullivan 2003).
vec3 ycocg(vec3 c)
{
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * c.r - 0.5 * c.b, -0.25 * c.r + 0.5 * c.g - 0.25 * c.b);
}

float luma(vec3 c) { return 0.25 * c.r + 0.5 * c.g + 0.25 * c.b; }

vec3 rgb_of(vec3 c) { return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z); }
