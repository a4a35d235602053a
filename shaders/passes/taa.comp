// The mean of this frame and those before. After Karis 2014, "High-Quality Temporal Supersampling" (weights by what the
// display makes of a sample, the nearest surface's motion for the pixels around it), Salvi 2016, "An Excursion in Temporal
// Supersampling" (colours of before within so many standard deviations) and Jimenez 2016, "Filmic SMAA" (bicubic fetch).
// What is thinner than a pixel is missed in many frames, and the colours around then know nothing of it. Where they contradict
// what was gathered now and then only, it is held to them less, for as many frames in a row as a thin line is missed.
#include "lib/depth_read.glsl"
#include "lib/half_float.glsl"
#include "lib/math.glsl"
#include "lib/taa.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_hdr;
layout(binding = 28) uniform sampler2D t_mean;
layout(binding = 29) uniform sampler2D t_seen;
layout(binding = 30) uniform sampler2D t_motion;
layout(binding = 1, rgba16f) uniform writeonly image2D i_mean;
layout(binding = 2, rgba16f) uniform writeonly image2D i_seen;  // depth, what flickers, motion

// of a depth: what lies so much before something hides it
const float HIDES = 1.1;
// frames in a row that a thin line may be missed; of how far it flickers, left by each frame that does not
const float MISSED = 3.0;
const float CALMS = 0.97;
// pixels a frame: what moved more unlike what is there now is another thing
const float ALIKE = 0.5;
// no less than this is a difference, after the display's curve
const float LEAST = 1.0 / 128.0;

// Depth that half floats tell apart to 2 % however far it is; in a parallel projection, whose depth is linear, itself.
const float DOUBLINGS = 40.0;
const float FARTHEST = exp2(-DOUBLINGS);
float stored_depth(float depth) { return view.camera.w > 0.5 ? DOUBLINGS + log2(max(depth, FARTHEST)) : depth; }

// 0 for what is no number
float kept_depth(float stored)
{
    float kept = stored > 0.0 ? min(stored, DOUBLINGS) : 0.0;
    return view.camera.w > 0.5 ? exp2(kept - DOUBLINGS) : kept;
}

// What flickers, and before the point for how many frames it was missed; 0 for what is no number.
float kept_flicker(float stored) { return stored > 0.0 ? min(stored, MISSED + 1.99) : 0.0; }

// Motion as its length and its angle in turns, so that nothing that is kept is below 0; what is no number is none.
const float LONGEST = 30000.0;
vec2 sane_motion(vec2 m) { return all(lessThanEqual(abs(m), vec2(LONGEST))) ? m : vec2(0.0); }

vec2 stored_motion(vec2 m)
{
    float l = length(m);
    return l > 0.0 ? vec2(min(l, LONGEST), fract(atan(m.y, m.x) / (2.0 * PI) + 1.0)) : vec2(0.0);
}

vec2 kept_motion(vec2 stored)
{
    float l = stored.x > 0.0 ? min(stored.x, LONGEST) : 0.0;
    float turn = stored.y > 0.0 ? min(stored.y, 1.0) * 2.0 * PI : 0.0;
    return l * vec2(cos(turn), sin(turn));
}

ivec2 inside(ivec2 p) { return clamp(p, ivec2(0), ivec2(view.size.xy) - 1); }

vec4 now_at(ivec2 p)
{
    vec4 c = texelFetch(t_hdr, inside(p), 0);
    return vec4(compressed(sanitise(c.rgb)), coverage(c.a));
}

// What was gathered, sanitised; at a texel that is there.
vec4 mean_at(ivec2 p)
{
    vec4 c = texelFetch(t_mean, inside(p), 0);
    return vec4(compressed(sanitise(c.rgb)), coverage(c.a));
}

vec4 cubic_weights(float t)
{
    // Catmull and Rom 1974
    float t2 = t * t;
    float t3 = t2 * t;
    return 0.5 * vec4(-t3 + 2.0 * t2 - t, 3.0 * t3 - 5.0 * t2 + 2.0, -3.0 * t3 + 4.0 * t2 + t, t3 - t2);
}

vec4 before_at(vec2 pixel)
{
    vec2 from = floor(pixel - 0.5);
    vec2 t = pixel - 0.5 - from;
    vec4 wx = cubic_weights(t.x);
    vec4 wy = cubic_weights(t.y);
    vec4 sum = vec4(0.0);
    for (int y = 0; y < 4; ++y)
        for (int x = 0; x < 4; ++x) sum += wx[x] * wy[y] * mean_at(ivec2(from) + ivec2(x - 1, y - 1));
    return vec4(max(sum.rgb, vec3(0.0)), sat(sum.a));
}

// Whether a surface at a depth was hidden by what was seen there, the farthest of the four texels around.
bool was_hidden(ivec2 p, float depth, float farthest)
{
    vec2 now = (vec2(p) + 0.5 - taa.jitter) * view.size.zw;
    vec4 before = taa.before_from_now * vec4(now.x * 2.0 - 1.0, 1.0 - now.y * 2.0, depth, 1.0);
    if (!(before.w > 0.0)) return true;
    float expected = before.z / before.w;
    return view.camera.w > 0.5 ? farthest > max(expected, FARTHEST) * HIDES : farthest > expected + 0.01;
}

// The mean as it is kept: rounded up or down by chance, so that what is added in small parts is not lost.
void keep(ivec2 p, vec4 c)
{
    vec3 light = expanded(c.rgb);
    float turn = fract(taa.turn + dot(vec2(p), vec2(0.7548776662, 0.5698402910)));  // R2: Roberts 2018
    vec3 step = exp2(floor(log2(max(light, vec3(6.2e-5)))) - 10.0);
    imageStore(i_mean, p, vec4(nearest_half(max(light + (turn - 0.5) * step, vec3(0.0))), c.a));
}

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(view.size.xy)))) return;
    float depth = depth_at(p);
    vec2 own = sane_motion(texelFetch(t_motion, p, 0).rg);
    vec4 now = now_at(p);
    if (taa.known < 0.5) {
        keep(p, now);
        imageStore(i_seen, p, vec4(stored_depth(depth), 0.0, stored_motion(own)));
        return;
    }
    if (taa.frozen > 0.5) {
        keep(p, mix(mean_at(p), now, taa.part));
        imageStore(i_seen, p, vec4(stored_depth(depth), kept_flicker(texelFetch(t_seen, p, 0).g), stored_motion(own)));
        return;
    }

    // what edges belong to moves as the nearest surface around does
    ivec2 nearest = p;
    float nearest_depth = depth;
    vec3 sum = vec3(0.0);
    vec3 squares = vec3(0.0);
    for (int k = 0; k < 9; ++k) {
        ivec2 q = p + ivec2(k % 3 - 1, k / 3 - 1);
        vec3 c = ycocg(now_at(q).rgb);
        sum += c;
        squares += c * c;
        float d = depth_at(q);
        if (d > nearest_depth) {
            nearest_depth = d;
            nearest = inside(q);
        }
    }
    vec2 moved = sane_motion(texelFetch(t_motion, nearest, 0).rg);
    // what is thinner than a pixel goes on as it went, while it is missed
    vec4 last = texelFetch(t_seen, p, 0);
    if (nearest_depth == depth && fract(kept_flicker(last.g)) > 0.0 && distance(kept_motion(last.ba), moved) < ALIKE) moved = kept_motion(last.ba);
    vec2 pixel = vec2(p) + 0.5 - moved;
    bool outside = any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, view.size.xy));

    // what was there: the farthest depth; of what moved as this does, what flickers most
    ivec2 from = ivec2(floor(pixel - 0.5));
    float farthest = 1.0;
    float flickers = 0.0;
    for (int k = 0; k < 4; ++k) {
        vec4 seen = texelFetch(t_seen, inside(from + ivec2(k & 1, k >> 1)), 0);
        farthest = min(farthest, kept_depth(seen.r));
        if (distance(kept_motion(seen.ba), moved) < ALIKE) flickers = max(flickers, fract(kept_flicker(seen.g)));
    }
    float missed = floor(kept_flicker(texelFetch(t_seen, inside(ivec2(pixel)), 0).g));
    // where something moved itself, what it hid is not known from cameras; there the colours around have to do
    bool dropped = outside || (own == moved && was_hidden(p, depth, farthest));

    vec3 mean = sum * (1.0 / 9.0);
    vec3 spread = taa.spread * sqrt(max(squares * (1.0 / 9.0) - mean * mean, vec3(0.0)));
    vec4 before = moved == vec2(0.0) ? mean_at(p) : before_at(outside ? vec2(p) + 0.5 : pixel);
    // towards the mean until it is within the box of what is around
    vec3 off = ycocg(before.rgb) - mean;
    bool told = all(lessThanEqual(abs(off), max(spread, vec3(LEAST))));
    float change = abs(luma(now.rgb) - luma(before.rgb));
    if (told) {
        flickers = missed > 0.0 && missed <= MISSED ? max(flickers, min(change, 0.99)) : CALMS * flickers;
        missed = 0.0;
    } else {
        missed = min(missed + 1.0, MISSED + 1.0);
        if (missed > MISSED) flickers = 0.0;
    }
    if (flickers < LEAST || dropped) flickers = 0.0;
    if (dropped) missed = 0.0;
    vec3 units = abs(off) / max(spread + taa.thin * flickers, vec3(1e-6));
    float most = max(units.x, max(units.y, units.z));
    vec3 held = rgb_of(mean + off / max(most, 1.0));
    // each fetch between texels softens: the faster, the fewer frames; measured best for 0 to 3 pixels a frame
    float part = dropped ? 1.0 : min(taa.part * (1.0 + min(length(moved), 2.0)), 1.0);
    keep(p, vec4(mix(max(held, vec3(0.0)), now.rgb, part), mix(before.a, now.a, part)));
    imageStore(i_seen, p, vec4(stored_depth(depth), missed + flickers, stored_motion(moved)));
}
