// Shadows of the first sun: cascaded maps of depth (1 towards the sun), looked up in light space.
// The maps and their fields of the view block come from engine/render/shadows; the bias is explained in bias.py there.
//   SHADOW_FILTER: FILTERS of engine/render/shadows/quality.py
#include "lib/disc.glsl"
#define SHADOW_MOMENTS (SHADOW_FILTER >= 8)
// the thesis's filters let the hardware compare: one depth for all four texels of a lookup
#define SHADOW_HARDWARE (SHADOW_FILTER >= 5 && SHADOW_FILTER <= 7)

#if SHADOW_MOMENTS
#include "lib/shadow_moments.glsl"
layout(binding = 12) uniform sampler2DArray t_sun_moments;
#elif SHADOW_HARDWARE
layout(binding = 11) uniform sampler2DArrayShadow t_sun_shadow;
#else
layout(binding = 12) uniform sampler2DArray t_sun_depth;
#endif

// engine/render/shadows/bias.py
const float SHADOW_FOOTPRINT = 1.5;       // texels that one lookup reaches
#if SHADOW_HARDWARE
const float SHADOW_LIFT = SHADOW_FOOTPRINT;
const float SHADOW_CONSTANT = 0.2;        // texels
const float SHADOW_MAX_SLOPE = 4.0;
#else
const float SHADOW_LIFT = 0.25;
const float SHADOW_CONSTANT = 0.4;
const float SHADOW_MAX_SLOPE = 8.0;
#endif
const float SHADOW_STEEPEST = 16.0;       // slope that msm is lifted for
const float SHADOW_MARGIN = 6.0;          // texels at the edge that only filters look into, fit.py
const float SHADOW_BLEND = 0.1;           // of a cascade's half width
const float SHADOW_MAX_PENUMBRA = 12.0;   // texels, pcss
const float SHADOW_MOST_LEVEL = 2.0;      // mips of moments, MIPS in engine/render/passes/shadow_moments.py

// What a point looks like to one cascade: where it looks, and the receiver's plane.
struct ShadowReceiver {
    vec3 at;      // light space, lifted off the surface, m
    vec2 slope;   // depth per distance of the receiver's plane
    float layer;
    vec4 square;  // view.shadow_cascades[2 * i]
    vec4 depth;   // view.shadow_cascades[2 * i + 1]
};

// p: light space; n: normal as shaded, f: normal of the triangle, both unit, in light space; radius: texels.
ShadowReceiver receiver(int i, vec3 p, vec3 n, vec3 f, float radius)
{
    ShadowReceiver r;
    r.layer = float(i);
    r.square = view.shadow_cascades[2 * i];
    r.depth = view.shadow_cascades[2 * i + 1];
    float texel = r.square.w;
    float sine = length(f.xy);
    float steep = sine / max(abs(f.z), 1e-4);
    float followed = min(1.0, SHADOW_MAX_SLOPE / max(steep, 1e-4));
    r.slope = -f.xy / (f.z < 0.0 ? min(f.z, -1e-4) : max(f.z, 1e-4)) * followed;
    float rest = 1.0 - followed;  // of the slope
    float lift = max(sine, length(n.xy)) * (SHADOW_HARDWARE ? SHADOW_LIFT + radius * rest : SHADOW_LIFT + (SHADOW_FOOTPRINT + radius) * rest);
    r.at = p + n * (lift * texel) + vec3(0.0, 0.0, SHADOW_CONSTANT * texel);
    return r;
}

vec3 shadow_uv(ShadowReceiver r, vec2 offset)
{
    vec2 ndc = (r.at.xy + offset - r.square.xy) * r.square.z;
    return vec3(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y, r.layer);
}

float shadow_depth(ShadowReceiver r, vec2 offset)
{
    return (r.at.z + dot(r.slope, offset) - r.depth.x) * r.depth.y;
}

// Depth of the receiver's plane over the middle of a texel. own, texel: where the point is and where it is, in texels.
float plane_depth(ShadowReceiver r, vec2 own, vec2 texel)
{
    vec2 off = (texel - own) * r.square.w;
    return clamp(shadow_depth(r, vec2(off.x, -off.y)), 0.0, 1.0);
}

#if SHADOW_MOMENTS
// What the blurred map leaves of the sun. Where a pixel is wider than a texel, the mean of as many as it covers.
// n, f: as in `receiver`; depth: along the view.
float shadow_moments(int i, vec3 p, vec3 n, vec3 f, float depth)
{
    float texel = view.shadow_cascades[2 * i].w;
    float pixel = length(view.place_y.xyz) * 2.0 * view.size.w * (view.camera.w > 0.5 ? depth : 1.0);
    float level = clamp(log2(max(pixel, 1e-30) / max(texel, 1e-30)), 0.0, SHADOW_MOST_LEVEL);
    ShadowReceiver r = receiver(i, p, n, f, 0.0);
    float sine = max(length(f.xy), length(n.xy));
    float slope = sine / max(sqrt(max(1.0 - sine * sine, 0.0)), 1e-4);
    // the mean depth around a point of a plane is its own, whatever the blur; evsm4's second warp bends it a little
    float lift = SHADOW_LIFT;
    float up = SHADOW_CONSTANT;
#if SHADOW_FILTER == 12
    // over a slope, the surface's own blurred depths darken what is less than their deviation before their mean
    float reach = max(0.55 * view.shadow.y + 0.3, SHADOW_FOOTPRINT * exp2(level));
    float followed = min(1.0, SHADOW_STEEPEST / max(slope, 1e-4));
    up += min(reach, 0.55 * view.shadow.y + 0.3 * exp2(level)) * slope * followed;
    lift += reach * (1.0 - followed);
#elif SHADOW_FILTER == 11
    lift += SHADOW_LIFT + SHADOW_FOOTPRINT * max(1.0, 0.3 * view.shadow.y) * max(1.0 - 4.0 / max(slope, 1e-4), 0.0);
#endif
    r.at = p + (n * (lift * sine) + vec3(0.0, 0.0, up)) * texel;
    vec4 m = textureLod(t_sun_moments, shadow_uv(r, vec2(0.0)), level);
    float t = 1.0 - 2.0 * clamp(shadow_depth(r, vec2(0.0)), 0.0, 1.0);
    float width = 2.0 * texel * r.depth.y;
    float steep = slope * width * (exp2(level) + view.shadow.y * view.shadow.y);
    return moment_visibility(m, t, view.shadow_fade.z, view.shadow_fade.w, width, steep);
}
#elif SHADOW_HARDWARE
// As the thesis has it: the same points for every pixel.
float shadow_poisson(ShadowReceiver r, int taps, float radius)
{
    float lit = 0.0;
    for (int k = 0; k < taps; ++k) {
        vec2 offset = POISSON[k] * (radius * r.square.w);
        lit += texture(t_sun_shadow, vec4(shadow_uv(r, offset), shadow_depth(r, offset)));
    }
    return lit / float(taps);
}
#else
// Where the point is in the map, in texels from its corner.
vec2 map_place(ShadowReceiver r) { return shadow_uv(r, vec2(0.0)).xy * vec2(textureSize(t_sun_depth, 0).xy); }

// 1 where the sun reaches the point of the receiver's plane at `at`, `own` being its place (both in texels). Each of the four
// texels around is compared with the plane over its own middle, so that a plane does not hide itself.
float shadow_tap(ShadowReceiver r, vec2 own, vec2 at)
{
#if SHADOW_FILTER == 0
    ivec2 texel = clamp(ivec2(floor(at)), ivec2(0), textureSize(t_sun_depth, 0).xy - 1);
    float met = texelFetch(t_sun_depth, ivec3(texel, int(r.layer)), 0).r;
    return plane_depth(r, own, vec2(texel) + 0.5) >= met ? 1.0 : 0.0;
#else
    vec2 low = floor(at - 0.5);
    vec2 part = at - 0.5 - low;
    vec2 corner = low + 1.0;  // where the four meet
    vec4 met = textureGather(t_sun_depth, vec3(corner / vec2(textureSize(t_sun_depth, 0).xy), r.layer));
    // lower left, lower right, upper right, upper left
    vec4 plane = vec4(plane_depth(r, own, corner + vec2(-0.5, 0.5)), plane_depth(r, own, corner + vec2(0.5, 0.5)),
                      plane_depth(r, own, corner + vec2(0.5, -0.5)), plane_depth(r, own, corner + vec2(-0.5, -0.5)));
    vec4 lit = vec4(greaterThanEqual(plane, met));
    vec2 rows = mix(lit.wx, lit.zy, part.x);
    return mix(rows.x, rows.y, part.y);
#endif
}

// Mean of `taps` lookups in a disc of `radius` texels; `turn` in radians.
float shadow_disc(ShadowReceiver r, int taps, float radius, float turn)
{
    vec2 own = map_place(r);
    vec2 direction = vec2(cos(turn), sin(turn));
    float lit = 0.0;
    for (int k = 0; k < taps; ++k) {
        lit += shadow_tap(r, own, own + direction * (radius * vogel_radius(k, taps)));
        direction = GOLDEN_TURN * direction;
    }
    return lit / float(taps);
}
#endif

#if SHADOW_FILTER == 4
// Fernando 2005, "Percentage-closer soft shadows", for a sun: the penumbra is as wide as the sun's disc seen over the
// distance to what casts. Radius in texels; negative where nothing casts.
float shadow_penumbra(ShadowReceiver r, float turn)
{
    const int taps = 12;
    float tangent = view.shadow.z;
    float widest = clamp(tangent * (1.0 / r.depth.y) / r.square.w, view.shadow.y, SHADOW_MAX_PENUMBRA);
    vec2 own = map_place(r);
    ivec2 last = textureSize(t_sun_depth, 0).xy - 1;
    vec2 direction = vec2(cos(turn), sin(turn));
    float distance_sum = 0.0;
    float casters = 0.0;
    for (int k = 0; k <= taps; ++k) {
        // the middle, too: what is smaller than the search hides it all the same
        ivec2 texel = clamp(ivec2(floor(own + (k < taps ? direction * (widest * vogel_radius(k, taps)) : vec2(0.0)))), ivec2(0), last);
        float above = texelFetch(t_sun_depth, ivec3(texel, int(r.layer)), 0).r - plane_depth(r, own, vec2(texel) + 0.5);
        if (above > 0.0) {
            distance_sum += above;
            casters += 1.0;
        }
        direction = GOLDEN_TURN * direction;
    }
    if (casters < 0.5) return -1.0;
    float above = distance_sum / (casters * r.depth.y);  // m
    return clamp(tangent * above / r.square.w, min(view.shadow.y, 1.0), SHADOW_MAX_PENUMBRA);
}
#endif

float cascade_visibility(int i, vec3 p, vec3 n, vec3 f, float turn, float depth)
{
#if SHADOW_MOMENTS
    return shadow_moments(i, p, n, f, depth);
#elif SHADOW_HARDWARE
    return shadow_poisson(receiver(i, p, n, f, view.shadow.y), 8 * (SHADOW_FILTER - 4), view.shadow.y);
#elif SHADOW_FILTER == 0 || SHADOW_FILTER == 1
    ShadowReceiver r = receiver(i, p, n, f, 0.0);
    vec2 own = map_place(r);
    return shadow_tap(r, own, own);
#elif SHADOW_FILTER == 4
    float radius = shadow_penumbra(receiver(i, p, n, f, 0.0), turn);
    if (radius < 0.0) return 1.0;
    return shadow_disc(receiver(i, p, n, f, radius), 16, radius, turn);
#else
    return shadow_disc(receiver(i, p, n, f, view.shadow.y), SHADOW_FILTER == 2 ? 8 : 16, view.shadow.y, turn);
#endif
}

// The first cascade that holds light-space point p, or -1; `edge`: 0 inside to 1 at its border.
int cascade_of(vec3 p, int first, out float edge)
{
    int count = int(view.shadow.x);
    for (int i = first; i < count; ++i) {
        vec4 square = view.shadow_cascades[2 * i];
        vec4 depth = view.shadow_cascades[2 * i + 1];
        vec2 q = abs(p.xy - square.xy) * square.z;
        float m = max(q.x, q.y);
        float limit = 1.0 - SHADOW_MARGIN * 2.0 * view.shadow.w;
        if (m < limit && p.z >= depth.x) {
            edge = i + 1 < count ? sat((m - limit + SHADOW_BLEND) / SHADOW_BLEND) : 0.0;
            return i;
        }
    }
    edge = 0.0;
    return -1;
}

vec3 light_space(vec3 v)
{
    return vec3(dot(view.shadow_axes[0].xyz, v), dot(view.shadow_axes[1].xyz, v), dot(view.shadow_axes[2].xyz, v));
}

// How much of the first sun reaches point p (relative to the origin): 1 all, 0 none.
// n: unit normal as interpolated; f: of the triangle, any length; pixel: seed of the filter's rotation.
float sun_visibility(vec3 p, vec3 n, vec3 f, uvec2 pixel)
{
    float edge;
    vec3 at = light_space(p);
    int i = cascade_of(at, 0, edge);
    if (i < 0) return 1.0;
    vec3 n_light = light_space(n);
    vec3 f_light = light_space(f);
    float f2 = dot(f_light, f_light);
    f_light = f2 > 1e-30 ? f_light * inversesqrt(f2) : n_light;  // also where it is not a number
    float turn = pixel_turn(pixel);
    float depth = -dot(vec4(view.view_from_origin[0].z, view.view_from_origin[1].z, view.view_from_origin[2].z,
                            view.view_from_origin[3].z), vec4(p, 1.0));
    float lit = cascade_visibility(i, at, n_light, f_light, turn, depth);
    if (edge > 0.0) {
        float ignored;
        int next = cascade_of(at, i + 1, ignored);
        if (next >= 0) lit += (cascade_visibility(next, at, n_light, f_light, turn, depth) - lit) * edge;
    }
    return lit + (1.0 - lit) * sat((depth - view.shadow_fade.x) * view.shadow_fade.y);
}

// Texels a metre of the map that a point reads, and how light to draw it: cells of 8 texels, light and dim; 0 where none.
vec2 shadow_texels(vec3 p)
{
    float edge;
    vec3 at = light_space(p);
    int i = cascade_of(at, 0, edge);
    if (i < 0 || view.shadow_cascades[2 * i].w <= 0.0) return vec2(0.0);
    vec2 cell = floor((at.xy - view.shadow_cascades[2 * i].xy) / (8.0 * view.shadow_cascades[2 * i].w));
    return vec2(1.0 / view.shadow_cascades[2 * i].w, 0.75 + 0.25 * mod(cell.x + cell.y, 2.0));
}

// Which cascade a point reads, as a colour; grey where none. After Okabe and Ito 2008, "Color Universal Design".
vec3 cascade_tint(vec3 p)
{
    float edge;
    int i = cascade_of(light_space(p), 0, edge);
    if (i < 0) return vec3(0.5);
    vec3 tints[4] = vec3[4](
        vec3(0.86, 0.15, 0.01), vec3(0.01, 0.44, 0.22), vec3(0.11, 0.55, 0.98), vec3(0.96, 0.85, 0.06));
    return mix(tints[i & 3], tints[(i + 1) & 3], edge);
}
