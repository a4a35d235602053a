// Rectangle and disk lights by linearly transformed cosines: Heitz, Dupuy, Hill and Neubelt 2016, "Real-Time
// Polygonal-Light Shading with Linearly Transformed Cosines". float64 twin and fit: engine/math/ltc.py; error:
// engine/experiments/area_lights.py. The Light struct is in the prelude, Reflector and distance_window in lib/lights.glsl.
#include "lib/brdf.glsl"
#include "lib/dfg.glsl"

layout(binding = 13) uniform sampler2D t_ltc;

// Corners of the polygon that stands for a disk; its area is the disk's. Eight would do for the sum of its light; sixteen for
// its outline in a smooth surface.
#ifndef DISK_CORNERS
#define DISK_CORNERS 16
#endif

const int AREA_DISK = 4;

// Angle between unit a and b times the normal of their plane (Lambert's formula for one edge).
vec3 edge_integral(vec3 a, vec3 b)
{
    vec3 across = cross(a, b);
    float sine = length(across);
    return across * (atan(sine, dot(a, b)) / max(sine, 1e-20));
}

// A flat convex light about the point it shines on, in a frame whose z is the normal: middle, half edges.
struct Patch {
    vec3 middle;
    vec3 right;
    vec3 up;
    bool disk;
};

Patch patch_through(mat3 m, Patch s) { return Patch(m * s.middle, m * s.right, m * s.up, s.disk); }

// The integral over the patch of unit directions times cos / pi, its part above z = 0; z is the form factor.
vec3 patch_flux(Patch s)
{
    float d2 = dot(s.middle, s.middle);
    float size2 = max(dot(s.right + s.up, s.right + s.up), dot(s.right - s.up, s.right - s.up));
    vec3 across = cross(s.right, s.up);
    if (size2 <= 1e-3 * d2) {
        // Small: the edges' sum would be the rounding of its parts. Area over distance squared is within 1e-3.
        vec3 l = s.middle * inversesqrt(max(d2, 1e-36));
        float area = (s.disk ? PI : 4.0) * abs(dot(across, l)) / max(d2, 1e-36);
        return l.z > 0.0 ? l * (area * (1.0 / PI)) : vec3(0.0);
    }
    int corners = s.disk ? DISK_CORNERS : 4;
    float step_angle = 2.0 * PI / float(corners);
    // of a regular polygon with the area of the unit disk
    float radius = sqrt(step_angle / sin(step_angle));
    mat2 turn = mat2(cos(step_angle), sin(step_angle), -sin(step_angle), cos(step_angle));
    vec2 at = s.disk ? vec2(radius, 0.0) : vec2(1.0);
    vec3 sum = vec3(0.0);
    vec3 leaves = vec3(0.0);
    vec3 enters = vec3(0.0);
    vec3 first = s.middle + at.x * s.right + at.y * s.up;
    vec3 a = first;
    for (int i = 0; i < corners; ++i) {
        at = turn * at;
        if (!s.disk) at = vec2(i == 0 || i == 1 ? -1.0 : 1.0, i == 1 || i == 2 ? -1.0 : 1.0);
        // the last is the first, bit for bit: the horizon cuts a closed outline twice or not at all
        vec3 b = i + 1 == corners ? first : s.middle + at.x * s.right + at.y * s.up;
        bool a_seen = a.z > 0.0;
        bool b_seen = b.z > 0.0;
        vec3 from = a;
        vec3 to = b;
        if (a_seen != b_seen) {
            vec3 cut = a + (b - a) * (a.z / (a.z - b.z));
            cut.z = 0.0;
            if (a_seen) { to = cut; leaves = cut; } else { from = cut; enters = cut; }
        }
        if (a_seen || b_seen) sum += edge_integral(safe_normalize(from), safe_normalize(to));
        a = b;
    }
    // the horizon closes what it cuts; both are zero where it cuts nothing
    sum += edge_integral(safe_normalize(leaves), safe_normalize(enters));
    // corners run one way or the other, by the side that is seen; towards the light is right
    return sum * ((dot(across, s.middle) > 0.0 ? 1.0 : -1.0) * (0.5 / PI));
}

// Normal, and the viewer in the XZ plane: rows of the frame.
mat3 viewing_frame(vec3 n, vec3 v)
{
    vec3 x = v - n * dot(n, v);
    if (dot(x, x) < 1e-10) x = cross(n, abs(n.x) < 0.9 ? vec3(1.0, 0.0, 0.0) : vec3(0.0, 1.0, 0.0));
    x = safe_normalize(x);
    return transpose(mat3(x, cross(n, x), n));
}

// Radiance reflected towards r.v of a rectangle or disk of luminance light.color.
vec3 area_lighting(Light light, vec3 p, Reflector r)
{
    vec3 to_light = light.position - p;
    vec3 up = cross(light.direction, light.right);
    float behind = dot(light.direction, to_light);  // negative in front
    if (behind >= 0.0 && (light.two_sided == 0u || behind == 0.0)) return vec3(0.0);
    float window = 1.0;
    if (light.range > 0.0) {
        // from the nearest point of the light; a disk counts as the rectangle around it
        vec2 at = vec2(dot(to_light, light.right), dot(to_light, up));
        vec2 beyond = max(abs(at) - light.half_size, vec2(0.0));
        window = range_window(dot(beyond, beyond) + behind * behind, light.range);
        if (window <= 0.0) return vec3(0.0);
    }
    mat3 frame = viewing_frame(r.n, r.v);
    Patch patch_seen = patch_through(
        frame, Patch(to_light, light.right * light.half_size.x, up * light.half_size.y, light.type == uint(AREA_DISK)));
    vec3 flux = patch_flux(patch_seen);
    if (flux.z <= 0.0) return vec3(0.0);

    // Diffuse: what the coat lets through, taken where most light comes from, so that a small light is a point light.
    vec3 h = safe_normalize(safe_normalize(flux) + frame * r.v);
    vec3 f = F_Schlick(r.f0, vec3(r.f90), dot(frame * r.v, h));
    vec3 lit = (1.0 - f) * r.diffuse_albedo * flux.z;

    float roughness = sqrt(r.alpha);
    vec4 m = textureLod(t_ltc, rim(vec2(sqrt(sat(1.0 - r.n_dot_v)), roughness), float(textureSize(t_ltc, 0).x)), 0.0);
    mat3 inverse_m = mat3(m.x, 0.0, m.z, 0.0, 1.0, 0.0, m.y, 0.0, m.w);
    float lobe = patch_flux(patch_through(inverse_m, patch_seen)).z;
    vec2 albedo = split_sum(r.n_dot_v, roughness);
    lit += (r.f0 * albedo.x + r.f90 * albedo.y) * max(lobe, 0.0);
    return light.color * (lit * window);
}
