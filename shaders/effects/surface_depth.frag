// Depth only: cuts away what the surface's alpha test cuts. Opaque casters have no work here.

#if ALPHA_TEST
#ifdef ALPHA_TO_COVERAGE
#include "lib/alpha_coverage.glsl"
#endif
layout(location = 2) flat in uint v_material;
#if HAS_UV0
layout(location = 4) in vec2 v_uv0;
#endif
#if UV1
layout(location = 5) in vec2 v_uv1;
#endif
#if VERTEX_COLOR
layout(location = 6) in vec4 v_color;
#endif
#endif

void main()
{
#if ALPHA_TEST
    MaterialParams m = materials[v_material];
#if HAS_UV0
    vec2 uv0 = v_uv0;
#else
    vec2 uv0 = vec2(0.0);
#endif
#if UV1
    vec2 uv1 = v_uv1;
#else
    vec2 uv1 = uv0;
#endif
    float alpha = m.base_color.a;
#if BASE_COLOR_MAP
    alpha *= sample_base_color_map(m, uv0, uv1).a;
#endif
#if VERTEX_COLOR
    alpha *= v_color.a;
#endif
#ifdef ALPHA_TO_COVERAGE
    gl_SampleMask[0] = alpha_coverage(alpha, m.alpha_cutoff);
#else
    if (alpha < m.alpha_cutoff) discard;
#endif
#endif
}
