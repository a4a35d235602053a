// Where the mips of nearest depths lie in one texture (engine/render/passes/scene_front.py): the picture at the left, and
// beside it, one under the other, its halves. Not in mips: see lib/quad.glsl.
ivec2 front_size(int level) { return max(ivec2(view.size.xy) >> level, ivec2(1)); }

ivec2 front_corner(int level)
{
    ivec2 corner = ivec2(level > 0 ? int(view.size.x) : 0, 0);
    for (int k = 1; k < level; ++k) corner.y += front_size(k).y;
    return corner;
}
