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

// Which of the four texels below stands for one of a smaller size: McGuire, Mara, Luebke 2012, "Scalable Ambient
// Obscurance", sect. 2.2 (rotated, so that no row or column is lost).
ivec2 finer_texel(ivec2 texel)
{
    return 2 * texel + ivec2((texel.y & 1) ^ 1, (texel.x & 1) ^ 1);
}

// The texel of the full size that one of `level` stands for. Sizes round down: all are inside.
ivec2 whole_texel(ivec2 texel, int level)
{
    for (int k = 0; k < level; ++k) texel = finer_texel(texel);
    return texel;
}
