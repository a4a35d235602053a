// What both layers send out as matt surfaces: light of suns and lamps, with their shadows, and what they emit. Also keeps
// their depths and which way they face, in the form that the gather reads.
#include "lib/deep_layers.glsl"
#include "lib/deep_read.glsl"
#include "lib/lights.glsl"
#if LOCAL_LIGHTS
#include "lib/local_lights.glsl"
#endif
#if SUN_SHADOWS
#include "lib/shadows.glsl"
#if TRANSLUCENT_SHADOWS
#include "lib/shadow_tint.glsl"
#endif
#endif

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 20) uniform sampler2D t_depth0;
#if LAYERS > 1
layout(binding = 22) uniform sampler2D t_depth1;
#endif
layout(binding = 1, rg32f) uniform writeonly image2D i_depth;
layout(binding = 2, rgba8) uniform writeonly image2D i_side;
layout(binding = 3, rgba16f) uniform writeonly image2D i_light0;
#if LAYERS > 1
layout(binding = 4, rgba16f) uniform writeonly image2D i_light1;
#endif
#if KEPT
layout(binding = 5, rgba16f) uniform writeonly image2D i_own0;
#if LAYERS > 1
layout(binding = 6, rgba16f) uniform writeonly image2D i_own1;
#endif
#endif

vec3 sent_out(ivec2 texel, DeepSurface s, vec3 p)
{
    vec3 sum = s.emission;
    Reflector r = Reflector(s.n, s.n, vec3(0.0), 0.0, s.albedo, 1.0, 1.0);
#if SUNS
    float lit = 1.0;
#if TRANSLUCENT_SHADOWS
    first_sun_tint = vec3(1.0);
    if (view.counts.y > 0u && dot(s.n, view.suns[0].xyz) < 0.0) first_sun_tint = sun_tint(p, s.n, s.n, uvec2(texel));
#endif
#if SUN_SHADOWS
    if (view.counts.y > 0u && dot(s.n, view.suns[0].xyz) < 0.0) lit = sun_visibility(p, s.n, s.n, uvec2(texel));
#endif
    sum += sun_lighting(r, lit);
#endif
#if LOCAL_LIGHTS
    sum = add_local_lights(sum, uvec2(texel), p, r, 0);
#endif
    return sanitise(sum);
}

vec4 layer(ivec2 texel, int which, float depth, out vec2 side)
{
    side = vec2(0.5);
    if (!(depth > 0.0)) return vec4(0.0);
    DeepSurface s = deep_surface(texel, which);
    vec3 p = layer_place(texel, depth);
    // what has no normal faces the camera
    if (s.n == vec3(0.0)) s.n = safe_normalize(view_vector(p));
    side = pack_side(s.n);
    return vec4(sent_out(texel, s, p), 1.0);
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (!inside_layers(texel)) return;
    vec2 depth = vec2(texelFetch(t_depth0, texel, 0).r, 0.0);
    vec2 side0;
    vec2 side1 = vec2(0.5);
    vec4 light0 = layer(texel, 0, depth.x, side0);
    imageStore(i_light0, texel, light0);
#if KEPT
    imageStore(i_own0, texel, light0);
#endif
#if LAYERS > 1
    depth.y = texelFetch(t_depth1, texel, 0).r;
    vec4 light1 = layer(texel, 1, depth.y, side1);
    imageStore(i_light1, texel, light1);
#if KEPT
    imageStore(i_own1, texel, light1);
#endif
#endif
    imageStore(i_depth, texel, vec4(depth, 0.0, 0.0));
    imageStore(i_side, texel, vec4(side0, side1));
}
