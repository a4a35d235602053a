// Pictures of half the size and less, each texel of which stands for one of the full size.

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
