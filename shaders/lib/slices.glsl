// The hemisphere over a place in slices through the view direction, each in 32 sectors of equal weight; what lies along a
// slice covers sectors (Therrien, Levesque, Gilet 2023, "Screen Space Indirect Lighting with Visibility Bitmask", sect. 3).
// Sectors are even in the inner integral of Jimenez et al. 2016, "Practical Realtime Strategies for Accurate Indirect
// Occlusion", eq. 7, and not in angle, so that all weigh the same.
struct Slice {
    vec3 side;    // at a right angle to v
    vec3 v;       // to the eye
    float gamma;  // of the normal's projection, from v towards side
    float size;   // of the normal's projection
    float low;    // weight_to the ends of the hemisphere
    float high;
    float jitter;
};

// What a surface seen at a steep angle goes back, of what it goes aside, in texels: places that lie no farther apart may be
// of one surface.
const float FALL = 4.0;

// Integral of |sin t| cos(t - gamma) from 0 to t, with the sign of t.
float weight_to(float t, float gamma)
{
    float area = 0.25 * (cos(gamma) + 2.0 * t * sin(gamma) - cos(2.0 * t - gamma));
    return t < 0.0 ? -area : area;
}

// `angle` from `first` towards `second`, which are at right angles to each other and to v.
Slice slice_at(vec3 v, vec3 n, vec3 first, vec3 second, float angle, float jitter)
{
    Slice s;
    s.v = v;
    s.side = cos(angle) * first + sin(angle) * second;
    vec3 axis = cross(s.side, v);
    vec3 projected = n - axis * dot(n, axis);
    s.size = max(length(projected), 1e-3);
    s.gamma = sign(dot(s.side, projected)) * acos(clamp(dot(projected, v) / s.size, -1.0, 1.0));
    s.low = weight_to(s.gamma - 0.5 * PI, s.gamma);
    s.high = weight_to(s.gamma + 0.5 * PI, s.gamma);
    s.jitter = jitter;
    return s;
}

// The sine and the cosine of the angle from v of a direction. Its height over the tangent plane is kept, whatever lies
// beside the slice; what is below the plane comes to lie in it, on the side that is walked (1: that of s.side, or -1).
vec2 place_in(Slice s, vec3 q, vec3 n, float side)
{
    vec2 at = vec2(dot(q, s.side), dot(q, s.v));
    vec2 normal = vec2(sin(s.gamma), cos(s.gamma));
    vec2 plane = vec2(normal.y, -normal.x);
    float height = dot(q, n) / s.size;
    float along = dot(at, plane);
    if (!(height > 0.0)) return side * plane;
    return (normal * height + plane * along) * inversesqrt(max(height * height + along * along, 1e-30));
}

// Abramowitz and Stegun 1964, "Handbook of Mathematical Functions", 4.4.45: off by 7e-5 at most.
float quick_acos(float x)
{
    float a = abs(x);
    float t = sqrt(max(1.0 - a, 0.0)) * (1.5707288 + a * (-0.2121144 + a * (0.0742610 - 0.0187293 * a)));
    return x < 0.0 ? PI - t : t;
}

// Where a place lies among the slice's sectors, 0 to 32.
float sector_of(Slice s, vec2 place)
{
    float t = quick_acos(place.y);
    vec2 twice = vec2(2.0 * abs(place.x) * place.y, 2.0 * place.y * place.y - 1.0);
    // as weight_to, of sine and cosine
    float tilt = place.x < 0.0 ? -sin(s.gamma) : sin(s.gamma);
    float area = 0.25 * (cos(s.gamma) * (1.0 - twice.y) + tilt * (2.0 * t - twice.x));
    return 32.0 * sat(((place.x < 0.0 ? -area : area) - s.low) / max(s.high - s.low, 1e-6));
}

// Of one of the sectors.
float sector_weight(Slice s) { return s.size * (s.high - s.low) * (1.0 / 32.0); }

uint bits_below(int count)
{
    return count <= 0 ? 0u : (count >= 32 ? 0xffffffffu : (1u << uint(count)) - 1u);
}

uint bits_between(Slice s, float a, float b)
{
    int first = int(floor(min(a, b) + s.jitter));
    int last = int(floor(max(a, b) + s.jitter));
    return bits_below(last) & ~bits_below(first);
}

// Where places that lie along d from p are in the picture: unit, rows of pixels go down.
vec2 picture_direction(vec3 p, vec3 d)
{
    vec3 right = safe_normalize(view.place_x.xyz);
    vec3 up = safe_normalize(view.place_y.xyz);
    vec2 along = vec2(dot(d, right), -dot(d, up));
    if (view.camera.w > 0.5) {
        vec3 q = p - view.camera.xyz;
        float forward = dot(d, safe_normalize(view.place_z.xyz));
        along = along * view_depth(p) - vec2(dot(q, right), -dot(q, up)) * forward;
    }
    return along * inversesqrt(max(dot(along, along), 1e-30));
}
