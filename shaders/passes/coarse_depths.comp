// How far both layers are at the coarse texels, for the next frame.
#include "lib/deep_layers.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_depths;
layout(binding = 1, rg32f) uniform writeonly image2D i_far;

float far_of(ivec2 whole, float depth)
{
    return depth > 0.0 ? view_depth(layer_place(whole, depth)) : 0.0;
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(i_far)))) return;
    vec2 depths = texelFetch(t_depths, texel, LEVEL).xy;
    ivec2 whole = whole_texel(texel, LEVEL);
    imageStore(i_far, texel, vec4(far_of(whole, depths.x), far_of(whole, depths.y), 0.0, 0.0));
}
