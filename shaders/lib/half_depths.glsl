// Pictures of half the size and less, each texel of which stands for one of the full size.

// The last texel of `level`, of level 0's size. By hand: where pixels ask for different levels at once, llvmpipe (Mesa 22.3) answers
// textureSize for all of them with that of the first.
ivec2 last_texel(ivec2 size, int level)
{
    return max(size >> level, ivec2(1)) - 1;
}

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
