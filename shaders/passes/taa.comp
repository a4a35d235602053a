// The mean of this frame and those before. After Karis 2014, "High-Quality Temporal Supersampling" (weights by what the
// display makes of a sample, the nearest surface's motion for the pixels around it), Salvi 2016, "An Excursion in Temporal
// Supersampling" (colours of before within so many standard deviations) and Jimenez 2016, "Filmic SMAA" (bicubic fetch).
#include "lib/depth_read.glsl"
#include "lib/math.glsl"
#include "lib/taa.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_hdr;
layout(binding = 28) uniform sampler2D t_mean;
layout(binding = 29) uniform sampler2D t_seen;
layout(binding = 30) uniform sampler2D t_motion;
layout(binding = 1, rgba32f) uniform writeonly image2D i_mean;
layout(binding = 2, r32f) uniform writeonly image2D i_seen;

// of a depth: what lies so much before something hides it
const float HIDES = 1.1;

vec4 now_at(ivec2 p)
{
    vec4 c = texelFetch(t_hdr, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0);
    return vec4(compressed(sanitise(c.rgb)), coverage(c.a));
}

// What was gathered, sanitised; at a texel that is there.
vec4 mean_at(ivec2 p)
{
    vec4 c = texelFetch(t_mean, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0);
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

// Whether all that was seen around a place lay before what is there now: then it was hidden.
bool was_hidden(ivec2 p, float depth, vec2 pixel)
{
    vec2 now = (vec2(p) + 0.5 - taa.jitter) * view.size.zw;
    vec4 before = taa.before_from_now * vec4(now.x * 2.0 - 1.0, 1.0 - now.y * 2.0, depth, 1.0);
    if (!(before.w > 0.0)) return true;
    float expected = before.z / before.w;
    ivec2 from = ivec2(floor(pixel - 0.5));
    float farthest = 1.0;
    for (int k = 0; k < 4; ++k) {
        ivec2 q = clamp(from + ivec2(k & 1, k >> 1), ivec2(0), ivec2(view.size.xy) - 1);
        farthest = min(farthest, texelFetch(t_seen, q, 0).r);
    }
    return view.camera.w > 0.5 ? farthest > expected * HIDES : farthest > expected + 0.01;
}

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(view.size.xy)))) return;
    float depth = depth_at(p);
    imageStore(i_seen, p, vec4(depth));
    vec4 now = now_at(p);
    if (taa.known < 0.5) {
        imageStore(i_mean, p, vec4(expanded(now.rgb), now.a));
        return;
    }
    if (taa.frozen > 0.5) {
        vec4 mean = mix(mean_at(p), now, taa.part);
        imageStore(i_mean, p, vec4(expanded(mean.rgb), mean.a));
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
            nearest = clamp(q, ivec2(0), ivec2(view.size.xy) - 1);
        }
    }
    vec2 moved = texelFetch(t_motion, nearest, 0).rg;
    vec2 pixel = vec2(p) + 0.5 - moved;
    bool outside = any(lessThan(pixel, vec2(0.0))) || any(greaterThan(pixel, view.size.xy));
    // where something moved itself, what it hid is not known from cameras; there the colours around have to do
    vec2 own = texelFetch(t_motion, p, 0).rg;
    bool dropped = outside || (own == moved && was_hidden(p, depth, pixel));

    vec3 mean = sum * (1.0 / 9.0);
    vec3 spread = taa.spread * sqrt(max(squares * (1.0 / 9.0) - mean * mean, vec3(0.0)));
    vec4 before = moved == vec2(0.0) ? mean_at(p) : before_at(outside ? vec2(p) + 0.5 : pixel);
    // towards the mean until it is within the box of what is around
    vec3 off = ycocg(before.rgb) - mean;
    vec3 units = abs(off) / max(spread, vec3(1e-6));
    float farthest = max(units.x, max(units.y, units.z));
    vec3 held = rgb_of(mean + off / max(farthest, 1.0));
    // each fetch between texels softens: the faster, the fewer frames; measured best for 0 to 3 pixels a frame
    float part = dropped ? 1.0 : min(taa.part * (1.0 + min(length(moved), 2.0)), 1.0);
    vec4 result = vec4(mix(max(held, vec3(0.0)), now.rgb, part), mix(before.a, now.a, part));
    imageStore(i_mean, p, vec4(expanded(result.rgb), result.a));
}
