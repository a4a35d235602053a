// Adds to what both layers send out themselves what they reflect of the light that was gathered at their coarse texels,
// and of the environment's that is left there. In motion that is of the frame before, found where the place was then.
#include "lib/deep_layers.glsl"
#include "lib/deep_read.glsl"
#include "lib/environment.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_depths;
layout(binding = 20) uniform sampler2D t_own0;
layout(binding = 22) uniform sampler2D t_coarse0;
layout(binding = 24) uniform sampler2D t_coarse_depths;
layout(binding = 3, rgba16f) uniform writeonly image2D i_light0;
#if LAYERS > 1
layout(binding = 23) uniform sampler2D t_own1;
layout(binding = 25) uniform sampler2D t_coarse1;
layout(binding = 4, rgba16f) uniform writeonly image2D i_light1;
#endif

// Mean over the coarse texels about `at` (in their count) that lie at this depth; w 0 where there is none.
vec4 coarse_light(vec2 at, int layer, float far)
{
    ivec2 middle = ivec2(floor(at));
    ivec2 last = textureSize(t_coarse_depths, 0) - 1;
    vec4 sum = vec4(0.0);
    float weights = 0.0;
    for (int k = 0; k < 9; ++k) {
        ivec2 texel = middle + ivec2(k % 3 - 1, k / 3 - 1);
        if (any(lessThan(texel, ivec2(0))) || any(greaterThan(texel, last))) continue;
        vec2 depths = texelFetch(t_coarse_depths, texel, 0).xy;
        float other = layer == 0 ? depths.x : depths.y;
        if (!(other > 0.0) || abs(other - far) > 0.1 * far) continue;
        vec2 aside = vec2(texel) + 0.5 - at;
        float weight = max(1.5 - length(aside), 0.01);
#if LAYERS > 1
        sum += weight * (layer == 0 ? texelFetch(t_coarse0, texel, 0) : texelFetch(t_coarse1, texel, 0));
#else
        sum += weight * texelFetch(t_coarse0, texel, 0);
#endif
        weights += weight;
    }
    return weights > 0.0 ? sum / weights : vec4(0.0);
}

vec3 sent_on(ivec2 texel, int layer, float depth, vec3 own)
{
    if (!(depth > 0.0)) return own;
    vec3 p = layer_place(texel, depth);
    vec2 coarse_size = vec2(textureSize(t_coarse_depths, 0));
    vec2 at = (vec2(texel) + 0.5) * gi.size.zw * coarse_size;
    float far = view_depth(p);
#if LIVE
    if (gi.known < 0.5) return own;
    vec4 clip = gi.before_clip * vec4(p, 1.0);
    far = dot(gi.before_depth, vec4(p, 1.0));
    if (!(clip.w > 0.0) || !(far > 0.0)) return own;
    vec2 ndc = clip.xy / clip.w;
    if (any(greaterThan(abs(ndc), vec2(1.0)))) return own;
    at = vec2(0.5 + 0.5 * ndc.x, 0.5 - 0.5 * ndc.y) * coarse_size;
#endif
    vec4 light = coarse_light(at, layer, far);
    DeepSurface s = deep_surface(texel, layer);
    vec3 n = s.n == vec3(0.0) ? safe_normalize(view_vector(p)) : s.n;
    // what comes back must be less than what came, or bounces add up without end
    vec3 back = min(s.albedo * gi.boost, vec3(0.95));
    vec3 arriving = float(LIT) * light.rgb;
#if SKY
    arriving += light.a * environment_irradiance(n);
#endif
    return sanitise(own + back * arriving);
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside_layers(texel)) return;
    vec2 depths = texelFetch(t_depths, texel, 0).xy;
    imageStore(i_light0, texel, vec4(sent_on(texel, 0, depths.x, texelFetch(t_own0, texel, 0).rgb), 1.0));
#if LAYERS > 1
    imageStore(i_light1, texel, vec4(sent_on(texel, 1, depths.y, texelFetch(t_own1, texel, 0).rgb), 1.0));
#endif
}
