// Shadows on a level floor that is not seen itself: how much of the light of a white, matt floor is missing, as the alpha
// of black.
#include "lib/environment.glsl"
#include "lib/lights.glsl"
#include "lib/position.glsl"
#include "lib/view.glsl"
#if SUN_SHADOWS
#include "lib/shadows.glsl"
#endif
#if LOCAL_SHADOWS
#include "lib/local_shadows.glsl"
#endif

layout(location = 0) out vec4 o_color;

// of depth: what lies on the floor, or is a floor itself, is before it
const float BEHIND = 1e-4;

void main()
{
    vec2 pixel = gl_FragCoord.xy;
    vec3 p = position_from_depth(pixel, 0.5);
    vec3 v = safe_normalize(view_vector(p));
    float along = (p.y - ground.height) / max(v.y, 1e-4);
    vec3 near = position_from_depth(pixel, 1.0);
    if (!(v.y > 1e-4) || !(near.y > ground.height)) discard;  // seen from below, or at the horizon
    p -= v * along;
    p.y = ground.height;
    vec4 clip = view.clip_from_origin * vec4(p, 1.0);
    gl_FragDepth = clip.z / clip.w * (1.0 - BEHIND);

    vec3 up = vec3(0.0, 1.0, 0.0);
    Reflector r = Reflector(up, v, vec3(0.0), 0.0, vec3(1.0), 1.0, max(v.y, 1e-4));
    vec3 lit = environment_irradiance(up) + sun_lighting(r, 1.0);
    vec3 missing = vec3(0.0);
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
        if (share.x + share.y + share.z > 0.0) missing += share * (1.0 - local_visibility(i, p, up, uvec2(pixel)));
#endif
    }
    vec3 weights = vec3(0.2126, 0.7152, 0.0722);
    float alpha = ground.strength * sat(dot(missing, weights) / max(dot(lit, weights), 1e-30));
    if (!(alpha > 0.0)) discard;
    o_color = vec4(0.0, 0.0, 0.0, alpha);
}
