// A texture's layer, small, as its data looks: colours encoded, normals with their z, single channels grey.
#include "lib/color.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2DArray t_source;
layout(location = 0) out vec4 o_color;

void main()
{
    vec2 size = vec2(textureSize(t_source, 0).xy);
    float lod = max(0.0, log2(max(size.x, size.y) / float(THUMBNAIL_SIZE)));
    // keep the aspect: the longer side fills the square
    vec2 uv = (v_uv - 0.5) * max(size.x, size.y) / size + 0.5;
    vec4 texel = textureLod(t_source, vec3(uv, float(LAYER)), lod);
#if KIND == 1
    vec3 rgb = srgb_from_linear(texel.rgb);
#elif KIND == 2
    vec2 xy = texel.rg * 2.0 - 1.0;
    vec3 rgb = vec3(texel.rg, sqrt(max(0.0, 1.0 - dot(xy, xy))) * 0.5 + 0.5);
#elif KIND == 3
    vec3 rgb = texel.rrr;
#else
    vec3 rgb = texel.rgb;
#endif
    bool inside = all(greaterThanEqual(uv, vec2(0.0))) && all(lessThanEqual(uv, vec2(1.0)));
    o_color = vec4(inside ? rgb : vec3(0.0), 1.0);
}
