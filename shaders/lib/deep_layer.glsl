// The main of effects/surface_layer.frag. LAYER 1 keeps what lies behind layer 0 by more than a minimum separation.
#include "lib/deep_texels.glsl"
#include "lib/position.glsl"
#if LAYER
layout(binding = 20) uniform sampler2D t_layer_depth;
#endif

layout(location = 0) out uvec2 o_shape;
layout(location = 1) out uvec2 o_light;

void main()
{
#if LAYER
    // no surface there, no second one: the coarser test comes first
    float front = texelFetch(t_layer_depth, ivec2(gl_FragCoord.xy), 0).r;
    if (!(front > 0.0)) discard;
    vec2 full = gl_FragCoord.xy * gi.scale;
    if (!(view_depth(v_position) > view_depth(position_from_depth(full, front)) + gi.separation)) discard;
#endif
    MaterialParams m = materials[v_material];
    Surface s = gather(m);
#if ALPHA_TEST
    if (s.base_color.a < m.alpha_cutoff) discard;
#endif
    vec3 albedo = s.base_color.rgb * (1.0 - s.metallic);
    vec3 n = s.normal;
#if UNLIT
    s.emission = s.base_color.rgb;
    albedo = vec3(0.0);
#endif
    // no normal packs to NO_REFLECTION: what has none is told apart
    bool known = dot(n, n) > 0.5 && dot(n, n) < 2.0;
    o_shape = uvec2(known ? packSnorm2x16(octahedral(n)) : NO_REFLECTION, packUnorm2x16(albedo.rg));
    o_light = uvec2(packUnorm2x16(vec2(albedo.b, s.roughness)), pack_shared_exponent(s.emission));
}
