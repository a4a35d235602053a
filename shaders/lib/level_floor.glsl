// A level floor that is not seen itself, at a height over the origin.
#include "lib/math.glsl"
#include "lib/position.glsl"
#include "lib/view.glsl"

// Where a pixel (its middle) shows it, and its depth there, a little behind what lies on it; 0 where it does not: seen from
// below, or at the horizon.
float floor_at(vec2 pixel, float height, out vec3 p, out vec3 v)
{
    const float BEHIND = 1e-4;  // of depth
    p = position_from_depth(pixel, 0.5);
    v = safe_normalize(view_vector(p));
    float along = (p.y - height) / max(v.y, 1e-4);
    vec3 near = position_from_depth(pixel, 1.0);
    if (!(v.y > 1e-4) || !(near.y > height)) return 0.0;
    p -= v * along;
    p.y = height;
    vec4 clip = view.clip_from_origin * vec4(p, 1.0);
    return clip.z / clip.w * (1.0 - BEHIND);
}
