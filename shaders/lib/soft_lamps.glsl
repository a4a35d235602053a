// Shadows of lamps with a size: as Fernando 2005, "Percentage-closer soft shadows", but with points of the light itself in
// the place of a disc in the map. Seen from a point p (q from the light's middle), what hides the light's point s and lies
// at a part b of the way from s to p is seen from the middle in direction q + s (1 - b) / b: so for every shape of light.
//   search: the mean (1 - b) / b of what is met there, where some point of the light is hidden by it
//   then:   lookups towards q + s times that mean, over the receiver's plane
layout(binding = 15) uniform sampler2D t_local_depth;
#if TRANSLUCENT_LAMPS
layout(binding = 27) uniform sampler2D t_local_tint;
#endif

const int SOFT_SEARCH = 20;
const int SOFT_TAPS = 16;
const float SOFT_REACH = 4.0;  // (1 - b) / b of what is looked for: from a fifth of the way on
const float SOFT_SLACK = 0.004;

// Where the tile that direction w meets has it: uv, and depth along the tile's axis per length of w.
struct LampTap {
    vec2 uv;
    float depth;
    float near;
    float texel;  // metres per metre of depth
    float far;
};

LampTap lamp_tap(vec4 head, vec3 w)
{
    uint at = uint(head.x) + (head.y > 1.5 ? LOCAL_ROWS * cube_face(w) : 0u);
    vec4 right = local_shadows[at];
    vec4 up = local_shadows[at + 1u];
    vec4 forward = local_shadows[at + 2u];
    vec4 square = local_shadows[at + 3u];
    float depth = max(dot(w, forward.xyz), square.z);
    vec2 ndc = vec2(dot(w, right.xyz), dot(w, up.xyz)) / (depth * forward.w);
    vec2 middle = vec2(right.w, up.w);
    float inside = square.x - 0.5 * square.w;
    return LampTap(clamp(middle + vec2(ndc.x, -ndc.y) * square.x, middle - inside, middle + inside), depth, square.z, square.y,
                   local_shadows[at + 4u].x);
}

// Point k of the light from its middle: disks and balls by Vogel's spiral; rectangles by Roberts 2018, "The unreasonable
// effectiveness of quasirandom sequences" (R2). In the unit disc or square.
vec2 lamp_sample(Light light, int k, float turn)
{
    if (light.type == 3u)
        return fract(vec2(0.7548776662, 0.5698402910) * (float(k) + 0.5) + vec2(turn, 131.0 * turn) * (0.5 / PI)) * 2.0 - 1.0;
    float angle = turn + float(k) * 2.39996322973;
    return vec2(cos(angle), sin(angle)) * vogel_radius(k, SOFT_TAPS);
}

// Where to search: denser in the middle, as what is near the receiver is found there alone.
vec2 search_sample(Light light, int k, float turn, out float part)
{
    part = (float(k) + 0.5) / float(SOFT_SEARCH);
    part *= part;
    float angle = turn + float(k) * 2.39996322973;
    vec2 at = vec2(cos(angle), sin(angle));
    return at * (light.type == 3u ? part / max(abs(at.x), abs(at.y)) : part);
}

// That point of the light, from its middle, in the world; a ball is a disk for each receiver q.
vec3 lamp_point(Light light, vec3 q, vec2 at)
{
    at *= light.half_size;
    if (light.type >= 3u) return light.right * at.x + cross(light.right, light.direction) * at.y;
    vec3 along = safe_normalize(q);
    vec3 right = safe_normalize(cross(abs(along.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), along));
    return right * at.x + cross(along, right) * at.y;
}

// How far along w (1: w itself) the receiver's plane through q lies at most; what lies beyond p hides nothing from it.
float plane_along(vec3 n, vec3 q, vec3 w)
{
    float own = dot(n, q);
    return own / min(dot(n, w), own);
}

// Along w, how far away what a tap meets is: what casts or, `tinted`, what is nearest of what tints.
float lamp_met(LampTap tap, bool tinted)
{
#if TRANSLUCENT_LAMPS
    if (tinted) return tap.far / max(textureLod(t_local_tint, tap.uv, 0.0).a, 1e-30);
#endif
    return tap.near / max(textureLod(t_local_depth, tap.uv, 0.0).r, 1e-30);
}

// q: from the light to the point, lifted off its surface; n: towards the light. Mean (1 - b) / b of what is met; negative
// where nothing is.
float soft_spread(Light light, vec4 head, vec3 q, vec3 n, float turn, bool tinted)
{
    float sum = 0.0;
    float found = 0.0;
    for (int k = 0; k < SOFT_SEARCH; ++k) {
        float part;
        vec3 w = q + SOFT_REACH * lamp_point(light, q, search_sample(light, k, turn, part));
        LampTap tap = lamp_tap(head, w);
        float b = lamp_met(tap, tinted) / (tap.depth * plane_along(n, q, w));
        float spread = (1.0 - b) / max(b, 1e-6);
        if (b < 1.0 - SOFT_SLACK && spread >= SOFT_REACH * part) {
            sum += min(spread, SOFT_REACH);
            found += 1.0;
        }
    }
    return found < 0.5 ? -1.0 : sum / found;
}

// Off the surface, as far as one lookup reaches; false where nothing can hide the point.
bool soft_lifted(vec4 head, vec3 n, inout vec3 q)
{
    LampTap own = lamp_tap(head, q);
    if (!(dot(q, q) > 0.0)) return false;
    float sine = sqrt(max(1.0 - dot(n, q) * dot(n, q) / dot(q, q), 0.0));
    q += n * (own.texel * own.depth * LOCAL_FOOTPRINT * max(sine, LOCAL_LEAST_SINE));
    return !(dot(n, q) > -1e-6 * length(q));
}

// How far along its tile's axis a tap on the receiver's plane is, less what keeps it from hiding itself.
float soft_depth(LampTap tap, vec3 n, vec3 q, vec3 w)
{
    return tap.depth * (plane_along(n, q, w) * (1.0 - SOFT_SLACK) - LOCAL_CONSTANT * tap.texel);
}

// As local_visibility; q: from the light to the point, n: towards the light.
float soft_visibility(uint i, vec4 head, vec3 q, vec3 n, uvec2 pixel)
{
    Light light = lights[i];
    float turn = pixel_turn(pixel);
    if (!soft_lifted(head, n, q)) return 1.0;
    float spread = soft_spread(light, head, q, n, turn, false);
    if (spread < 0.0) return 1.0;
    float lit = 0.0;
    for (int k = 0; k < SOFT_TAPS; ++k) {
        vec3 w = q + spread * lamp_point(light, q, lamp_sample(light, k, turn + 1.0));
        LampTap tap = lamp_tap(head, w);
        float along = tap.near / max(soft_depth(tap, n, q, w), tap.near);
#if LOCAL_MOMENTS
        lit += along >= textureLod(t_local_depth, tap.uv, 0.0).r ? 1.0 : 0.0;
#else
        lit += textureLod(t_local_shadow, vec3(tap.uv, along), 0.0);
#endif
    }
    return lit / float(SOFT_TAPS);
}
