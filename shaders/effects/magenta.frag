// Shown where an effect's own fragment shader does not compile: a colour that no one takes for right.

layout(location = 0) out vec4 o_color;

void main()
{
    o_color = vec4(1.0, 0.0, 1.0, 1.0);
}
