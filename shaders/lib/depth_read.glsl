// The depth of the picture so far, at whole pixels; where there are several samples, the first one's.
#if SAMPLES > 1
layout(binding = 20) uniform sampler2DMS t_depth;
#else
layout(binding = 20) uniform sampler2D t_depth;
#endif

// Reversed: 1 near, 0 nothing there. Outside of the picture, that of its border.
float depth_at(ivec2 pixel)
{
    return texelFetch(t_depth, clamp(pixel, ivec2(0), ivec2(view.size.xy) - 1), 0).r;
}
