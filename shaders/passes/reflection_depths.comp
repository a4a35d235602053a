// Of what both layers hold, at half the size and less: the nearest depth and the farthest, so that a ray can leave out whole
// pieces of the picture (Greene, Kass, Miller 1993, "Hierarchical Z-Buffer Visibility"; Uludag 2014, "Hi-Z Screen-Space
// Cone-Traced Reflections", GPU Pro 5). Depth is reversed; where nothing is, nearest 0 and farthest 1.
layout(local_size_x = 8, local_size_y = 8) in;
layout(binding = 10) uniform sampler2D t_depths;
#if LEVEL > 0
layout(binding = 17) uniform sampler2D t_before;
#endif
layout(binding = 1, rg32f) uniform writeonly image2D i_range;

// A bad number is nothing.
bool depth_is(float depth) { return depth > 0.0 && depth <= 1.0; }

vec2 range_at(ivec2 texel)
{
#if LEVEL > 0
    return texelFetch(t_before, texel, LEVEL - 1).xy;
#else
    vec2 depths = texelFetch(t_depths, texel, 0).xy;
    depths = mix(vec2(0.0), depths, bvec2(depth_is(depths.x), depth_is(depths.y)));
    return vec2(depths.x, depths.y > 0.0 ? depths.y : (depths.x > 0.0 ? depths.x : 1.0));
#endif
}

void main()
{
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    ivec2 size = imageSize(i_range);
    if (any(greaterThanEqual(texel, size))) return;
#if LEVEL > 0
    ivec2 last = textureSize(t_before, LEVEL - 1) - 1;
#else
    ivec2 last = textureSize(t_depths, 0) - 1;
#endif
    // the last row and column stand for what an odd size leaves over
    ivec2 end = mix(min(2 * texel + 1, last), last, equal(texel, size - 1));
    vec2 range = vec2(0.0, 1.0);
    for (int y = 2 * texel.y; y <= end.y; ++y) {
        for (int x = 2 * texel.x; x <= end.x; ++x) {
            vec2 one = range_at(ivec2(x, y));
            range = vec2(max(range.x, one.x), min(range.y, one.y));
        }
    }
    imageStore(i_range, texel, vec4(range, 0.0, 0.0));
}
