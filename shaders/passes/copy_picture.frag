// The finished picture as it is, byte for byte.
layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_picture;
layout(location = 0) out vec4 o_color;

void main() { o_color = texelFetch(t_picture, ivec2(gl_FragCoord.xy), 0); }
