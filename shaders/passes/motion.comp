// How far what a pixel shows has moved since the frame before, in pixels: as drawn where it moved itself, else from its
// depth and the two cameras. Depth 0 (nothing there) is a direction: infinitely far, in a projection without a far plane.
#include "lib/depth_read.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
#if MOVING
#if SAMPLES > 1
layout(binding = 10) uniform sampler2DMS t_drawn;
#else
layout(binding = 10) uniform sampler2D t_drawn;
#endif
#endif
layout(binding = 1, rg16f) uniform writeonly image2D i_motion;

#include "lib/motion.glsl"

void main()
{
    ivec2 p = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(p, ivec2(view.size.xy)))) return;
    vec2 moved = vec2(0.0);
    if (motion.still < 0.5) {
        vec2 pixel = vec2(p) + 0.5 - motion.jitter;
        vec2 ndc = vec2(pixel.x * 2.0 * view.size.z - 1.0, 1.0 - pixel.y * 2.0 * view.size.w);
        moved = pixels_moved(ndc, motion.before_from_now * vec4(ndc, depth_at(p), 1.0));
    }
#if MOVING
    vec2 drawn = texelFetch(t_drawn, p, 0).rg;
    if (motion.drawn > 0.5 && drawn.x < 31000.0) moved = drawn;
#endif
    imageStore(i_motion, p, vec4(moved, 0.0, 0.0));
}
