// Place and facet normal of what a pixel shows, from depth alone.
#include "lib/depth_read.glsl"
#include "lib/math.glsl"
#include "lib/position.glsl"
#include "lib/view.glsl"

bool inside_picture(ivec2 pixel)
{
    return pixel.x >= 0 && pixel.y >= 0 && pixel.x < int(view.size.x) && pixel.y < int(view.size.y);
}

// Relative to the origin.
vec3 place_at(ivec2 pixel, float depth)
{
    return position_from_depth(vec2(pixel) + 0.5, depth);
}

// From p to the neighbour one pixel on along `along`, or from the one before it: the nearer, which lies on the same body.
vec3 edge_along(ivec2 pixel, vec3 p, ivec2 along)
{
    ivec2 next = pixel + along;
    ivec2 last = pixel - along;
    float after = inside_picture(next) ? depth_at(next) : 0.0;
    float before = inside_picture(last) ? depth_at(last) : 0.0;
    if (!(after > 0.0) && !(before > 0.0)) return vec3(0.0);
    vec3 forward = after > 0.0 ? place_at(next, after) - p : vec3(3e18);
    vec3 backward = before > 0.0 ? p - place_at(last, before) : vec3(3e18);
    return dot(forward, forward) < dot(backward, backward) ? forward : backward;
}

// Unit normal of the facet, towards the camera; where a pixel stands alone, straight to the camera.
vec3 facet_normal(ivec2 pixel, vec3 p)
{
    vec3 v = safe_normalize(view_vector(p));
    vec3 n = cross(edge_along(pixel, p, ivec2(0, 1)), edge_along(pixel, p, ivec2(1, 0)));
    float size = dot(n, n);
    if (!(size > 0.0)) return v;
    n *= inversesqrt(size);
    return dot(n, v) < 0.0 ? -n : n;
}

// Pixels that a metre across the view covers at distance d along its axis.
float pixels_per_metre(float d)
{
    float half_height = length(view.place_y.xyz) * (view.camera.w > 0.5 ? max(d, 1e-30) : 1.0);
    return 0.5 * view.size.y / half_height;
}
