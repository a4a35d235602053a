// Depth only: cuts away what the surface's alpha test cuts. Opaque casters have no work here. MOTION: and how far the
// surface is from where it was, in pixels.
#ifdef MOTION
#include "lib/motion.glsl"
layout(location = 11) in vec4 v_before;
layout(location = 0) out vec2 o_motion;
#endif

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
#ifdef MOTION
    vec2 pixel = gl_FragCoord.xy - motion.jitter;
    o_motion = pixels_moved(vec2(pixel.x * 2.0 * view.size.z - 1.0, 1.0 - pixel.y * 2.0 * view.size.w), v_before);
#endif
}
