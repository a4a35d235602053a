// Shadows on a level floor that is not seen itself: how much of the light of a white, matt floor is missing, as the alpha
// of black.
#include "lib/environment.glsl"
#include "lib/lights.glsl"
#include "lib/level_floor.glsl"
#if AMBIENT_VISIBILITY
#include "lib/ambient_occlusion.glsl"
#endif
#if SUN_SHADOWS
#include "lib/shadows.glsl"
#endif
#if LOCAL_SHADOWS
#include "lib/local_shadows.glsl"
#endif

layout(location = 0) out vec4 o_color;

void main()
{
    vec2 pixel = gl_FragCoord.xy;
    vec3 p;
    vec3 v;
    gl_FragDepth = floor_at(pixel, ground.height, p, v);
    if (!(gl_FragDepth > 0.0)) discard;

    vec3 up = vec3(0.0, 1.0, 0.0);
    Reflector r = Reflector(up, v, vec3(0.0), 0.0, vec3(1.0), 1.0, max(v.y, 1e-4));
    vec3 lit = environment_irradiance(up) + sun_lighting(r, 1.0);
    vec3 missing = vec3(0.0);
#if AMBIENT_VISIBILITY
    missing += environment_irradiance(up) * (1.0 - ambient_visibility(pixel));
#endif
#if SUN_SHADOWS
    if (view.counts.y > 0u && view.suns[0].y < 0.0) {
        float hidden = 1.0 - sun_visibility(p, up, up, uvec2(pixel));
        missing += hidden * (sun_lighting(r, 1.0) - sun_lighting(r, 0.0));
    }
#endif
    for (uint i = 0u; i < view.counts.x; ++i) {
        vec3 share = sanitise(light_contribution(i, p, r));
        lit += share;
#if LOCAL_SHADOWS
        if (share.x + share.y + share.z > 0.0) {
            vec3 left = vec3(local_visibility(i, p, up, uvec2(pixel)));
#if TRANSLUCENT_LAMPS
            left *= local_tint(i, p, up, uvec2(pixel));
#endif
            missing += share * (1.0 - left);
        }
#endif
    }
    vec3 weights = vec3(0.2126, 0.7152, 0.0722);
    float alpha = ground.strength * sat(dot(missing, weights) / max(dot(lit, weights), 1e-30));
    if (!(alpha > 0.0)) discard;
    o_color = vec4(0.0, 0.0, 0.0, alpha);
}
