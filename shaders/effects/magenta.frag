// Shown where an effect's own fragment shader does not compile: a colour that no one takes for right, and no light on it.
// It includes nothing: what it would include may be what is broken.

layout(location = 0) out vec4 o_color;
#if defined(GBUFFER) && GBUFFER
// as lib/gbuffer.glsl has it
layout(location = 1) out uvec2 o_gbuffer0;
#if GBUFFER_LAYOUT == 0
layout(location = 2) out uint o_gbuffer1;
#else
layout(location = 2) out uvec2 o_gbuffer1;
#endif
#if GBUFFER_LAYOUT == 2
layout(location = 3) out uint o_gbuffer2;
#endif
#endif

void main()
{
    o_color = vec4(1.0, 0.0, 1.0, 1.0);
#if defined(GBUFFER) && GBUFFER
    o_gbuffer0 = uvec2(0x80008000u, 0u);  // NO_REFLECTION
#if GBUFFER_LAYOUT == 0
    o_gbuffer1 = 0u;
#else
    o_gbuffer1 = uvec2(0u);
#endif
#if GBUFFER_LAYOUT == 2
    o_gbuffer2 = 0u;
#endif
#endif
}
