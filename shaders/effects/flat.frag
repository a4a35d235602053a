// One colour, no light: base colour, or a checker over the texture coordinates.
#include "lib/debug_views.glsl"

layout(location = 1) in vec3 v_normal;
layout(location = 2) flat in uint v_material;
#if HAS_UV0
layout(location = 4) in vec2 v_uv0;
#endif
layout(location = 0) out vec4 o_color;

void main()
{
    MaterialParams m = materials[v_material];
    vec3 color = m.base_color.rgb;
#ifdef CHECKER
#if HAS_UV0
    // a little light from above keeps shapes readable
    color *= uv_checker_view(v_uv0 * m.repeats) * (0.75 + 0.25 * sat(safe_normalize(v_normal).y * 0.5 + 0.5));
#else
    color *= vec3(0.8, 0.0, 0.6);  // the mesh has no texture coordinates
#endif
#endif
    float alpha = BLENDED == 1 ? coverage(m.base_color.a) : 1.0;
    o_color = vec4(sanitise(color * (m.emissive_strength)) * alpha, alpha);
}
