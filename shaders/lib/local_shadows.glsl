// Shadows of point and spot lights: tiles of one map of depth (1e-6 m / distance along the tile's axis), from
// engine/render/shadows/local.py. All paths know the point and the shaded normal alike, and nothing else is asked for, so
// that all get the same bits.
#include "lib/disc.glsl"

#define LOCAL_MOMENTS (SHADOW_FILTER >= 8)
#if LOCAL_MOMENTS
#include "lib/shadow_moments.glsl"
layout(binding = 26) uniform sampler2D t_local_moments;  // of distances along the tile's axis, over its farthest
#else
layout(binding = 26) uniform sampler2DShadow t_local_shadow;
#endif
// Per light of the table: first row of its tiles, how many tiles, filter radius in texels, 1 where its size softens its
// shadows. Then per tile:
//   right, u of its middle; up, v of its middle; forward, tangent of half its angle; half width in uv, texel per metre of
//   depth, near, texel in uv; metres that nothing which casts is away
layout(std430, binding = 11) readonly buffer LocalShadowBlock { vec4 local_shadows[]; };

const uint LOCAL_ROWS = 5u;          // of a tile
const float LOCAL_STEEPEST = 16.0;   // slope that msm is lifted for
const float LOCAL_FOOTPRINT = 1.5;   // texels that one lookup reaches, engine/render/shadows/bias.py
// texels towards the light, and as many per texel of the filter's radius: where walls meet, what a lookup finds beside the
// point is the other wall, as far before this one's plane as a texel is wide
const float LOCAL_CONSTANT = 0.75;
const float LOCAL_PER_RADIUS = 0.75;
const float LOCAL_LEAST_SINE = 0.3;  // a normal map may face the light where its surface does not

// Which face of a cube direction q meets: +X -X +Y -Y +Z -Z.
uint cube_face(vec3 q)
{
    vec3 a = abs(q);
    uint axis = a.x >= a.y && a.x >= a.z ? 0u : (a.y >= a.z ? 1u : 2u);
    float along = axis == 0u ? q.x : (axis == 1u ? q.y : q.z);
    return 2u * axis + (along < 0.0 ? 1u : 0u);
}

// Where a receiver looks into its light's map, lifted off its surface.
struct LampReceiver {
    vec2 middle;   // uv
    vec2 low;      // uv of the tile
    vec2 high;
    float depth;   // along the tile's axis, m
    float texel;   // m, there
    float radius;  // of the filter, texels
    float unit;    // texel in uv
    float near;
    float far;
    float sine;    // of the angle between normal and axis
};

// q: from the light; n: unit, as shaded. False where nothing can hide the point.
bool lamp_receiver(vec4 head, vec3 q, vec3 n, out LampReceiver r)
{
    uint at = uint(head.x) + (head.y > 1.5 ? LOCAL_ROWS * cube_face(q) : 0u);
    vec4 right = local_shadows[at];
    vec4 up = local_shadows[at + 1u];
    vec4 forward = local_shadows[at + 2u];
    vec4 square = local_shadows[at + 3u];
    r.near = square.z;
    r.unit = square.w;
    r.far = local_shadows[at + 4u].x;
    r.depth = dot(q, forward.xyz);
    if (!(r.depth > r.near)) return false;  // behind the view, or at the light
    // The surface itself must not hide what a lookup compares up to `reach` texels beside the point: as in bias.py, where
    // the axis of the view stands for the sun. A texel grows with the distance.
    if (dot(n, q) > 0.0) n = -n;
    vec2 aside = vec2(dot(n, right.xyz), dot(n, up.xyz));
    r.radius = SHADOW_FILTER >= 2 ? head.z : 0.0;
    r.texel = square.y * r.depth;
    r.sine = length(aside);
    q += n * (r.texel * (LOCAL_FOOTPRINT + (LOCAL_MOMENTS ? 0.0 : r.radius)) * max(r.sine, LOCAL_LEAST_SINE));
    r.depth = max(dot(q, forward.xyz), r.near);
    vec2 ndc = vec2(dot(q, right.xyz), dot(q, up.xyz)) / (r.depth * forward.w);
    r.middle = vec2(right.w, up.w) + vec2(ndc.x, -ndc.y) * square.x;
    r.low = vec2(right.w, up.w) - (square.x - 0.5 * r.unit);
    r.high = vec2(right.w, up.w) + (square.x - 0.5 * r.unit);
    return true;
}

#if SOFT_LAMPS
#include "lib/soft_lamps.glsl"
#endif
#if TRANSLUCENT_LAMPS
#include "lib/local_tint.glsl"
#endif

#if LOCAL_MOMENTS
float local_moments(LampReceiver r)
{
    float slope = r.sine / max(sqrt(max(1.0 - r.sine * r.sine, 0.0)), 1e-4);
    float before = LOCAL_CONSTANT;
#if SHADOW_FILTER == 12
    before += 0.55 * r.radius * min(slope, LOCAL_STEEPEST);  // as in lib/shadows.glsl
#endif
    float t = 2.0 * clamp((r.depth - before * r.texel) / r.far, 0.0, 1.0) - 1.0;
    float width = 2.0 * r.texel / r.far;
    vec4 m = textureLod(t_local_moments, clamp(r.middle, r.low, r.high), 0.0);
    return moment_visibility(m, t, view.shadow_fade.z, view.shadow_fade.w, width, slope * width * (1.0 + r.radius * r.radius));
}
#endif

// How much of light i reaches point p (relative to the origin), as far as things hide it: 1 all, 0 none. n: as shaded, unit.
float local_visibility(uint i, vec3 p, vec3 n, uvec2 pixel)
{
    vec4 head = local_shadows[i];
    if (head.y < 0.5) return 1.0;
    vec3 q = p - lights[i].position;
#if SOFT_LAMPS
    if (head.w > 0.5) return soft_visibility(i, head, q, dot(n, q) > 0.0 ? -n : n, pixel);
#endif
    LampReceiver r;
    if (!lamp_receiver(head, q, n, r)) return 1.0;
#if LOCAL_MOMENTS
    return local_moments(r);
#else
    float along = r.near / max(r.depth - (LOCAL_CONSTANT + LOCAL_PER_RADIUS * r.radius) * r.texel, r.near);
#if SHADOW_FILTER >= 2
    const int taps = SHADOW_FILTER == 3 || SHADOW_FILTER == 4 || SHADOW_FILTER == 6 ? 16 : SHADOW_FILTER == 7 ? 24 : 8;
    float turn = pixel_turn(pixel);
    vec2 direction = vec2(cos(turn), sin(turn));
    float lit = 0.0;
    for (int k = 0; k < taps; ++k) {
#if SHADOW_FILTER >= 5 && SHADOW_FILTER <= 7
        vec2 uv = r.middle + POISSON[k] * (r.radius * r.unit);
#else
        vec2 uv = r.middle + direction * (r.radius * r.unit * vogel_radius(k, taps));
#endif
        lit += textureLod(t_local_shadow, vec3(clamp(uv, r.low, r.high), along), 0.0);
        direction = GOLDEN_TURN * direction;
    }
    return lit / float(taps);
#else
    return textureLod(t_local_shadow, vec3(clamp(r.middle, r.low, r.high), along), 0.0);
#endif
#endif
}
