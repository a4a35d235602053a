// Places of texels of the deep G-buffer's layers, which may be smaller than the picture. Depth is reversed, 0: nothing there.
#include "lib/math.glsl"
#include "lib/octahedral.glsl"
#include "lib/position.glsl"
#include "lib/view.glsl"

bool inside_layers(ivec2 texel)
{
    return texel.x >= 0 && texel.y >= 0 && texel.x < int(gi.size.x) && texel.y < int(gi.size.y);
}

// Relative to the origin.
vec3 layer_place(ivec2 texel, float depth)
{
    return position_from_depth((vec2(texel) + 0.5) * gi.scale, depth);
}

// Unit normals in two channels of 8 bits: which side a surface turns to is all that is asked of them.
vec2 pack_side(vec3 n) { return octahedral(n) * 0.5 + 0.5; }

vec3 unpack_side(vec2 word) { return from_octahedral(word * 2.0 - 1.0); }

#include "lib/half_depths.glsl"
