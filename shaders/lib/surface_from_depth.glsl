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

// How far the depth at `pixel` lies off the line through the two pixels that follow it along `along`; large where one of
// them shows nothing. Depth is affine over the picture on a plane, for both kinds of camera.
float off_line(ivec2 pixel, float depth, float next, ivec2 along)
{
    ivec2 second = pixel + 2 * along;
    float beyond = inside_picture(second) ? depth_at(second) : 0.0;
    return next > 0.0 ? abs(beyond > 0.0 ? 2.0 * next - beyond - depth : next - depth) : 3e38;
}

// From p to the neighbour one pixel on along `along`, or from the one before it: whichever side goes straight on to p, for
// that lies on the same facet, also where two meet.
vec3 edge_along(ivec2 pixel, vec3 p, float depth, ivec2 along)
{
    ivec2 next = pixel + along;
    ivec2 last = pixel - along;
    float after = inside_picture(next) ? depth_at(next) : 0.0;
    float before = inside_picture(last) ? depth_at(last) : 0.0;
    if (!(after > 0.0) && !(before > 0.0)) return vec3(0.0);
    bool forward = off_line(pixel, depth, after, along) < off_line(pixel, depth, before, -along);
    return forward ? place_at(next, after) - p : p - place_at(last, before);
}

// Unit normal of the facet, towards the camera; where a pixel stands alone, straight to the camera.
vec3 facet_normal(ivec2 pixel, vec3 p, float depth)
{
    vec3 v = safe_normalize(view_vector(p));
    vec3 n = cross(edge_along(pixel, p, depth, ivec2(0, 1)), edge_along(pixel, p, depth, ivec2(1, 0)));
    float size = dot(n, n);
    if (!(size > 0.0)) return v;
    n *= inversesqrt(size);
    return dot(n, v) < 0.0 ? -n : n;
}
