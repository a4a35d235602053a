layout(location = 0) in vec3 a_position;
#if HAS_UV0
layout(location = 3) in vec2 a_uv0;
#endif

layout(location = 0) out vec2 v_uv;

void main()
{
#if HAS_UV0
    v_uv = a_uv0;
#else
    v_uv = a_position.xy;
#endif
    gl_Position = vec4(a_position, 1.0);
}
