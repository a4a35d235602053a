// What the texels of ambient occlusion between its shaders say: x y z, from the normal to the mean open direction; w, how
// much is open.
#if BENT
#define VISIBLE(texel) (texel)
#define TEXEL(visible) (visible)
#else
#define VISIBLE(texel) vec4(0.0, 0.0, 0.0, (texel).r)
#define TEXEL(visible) vec4((visible).w)
#endif
