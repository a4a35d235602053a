// Each pixel takes the parts that lie beyond its edges from its neighbours there, in linear light: across rows or across
// columns, whichever is more.
#include "lib/color.glsl"

layout(location = 0) in vec2 v_uv;
layout(binding = 10) uniform sampler2D t_picture;
layout(binding = 11) uniform sampler2D t_parts;
layout(location = 0) out vec4 o_color;

vec4 parts_at(ivec2 p)
{
    return all(lessThan(p, ivec2(view.size.xy))) ? texelFetch(t_parts, p, 0) : vec4(0.0);
}

vec4 picture_at(ivec2 p) { return texelFetch(t_picture, clamp(p, ivec2(0), ivec2(view.size.xy) - 1), 0); }

vec4 light_at(ivec2 p)
{
    vec4 c = picture_at(p);
    return vec4(linear_from_srgb(c.rgb), c.a);
}

void main()
{
    ivec2 p = ivec2(gl_FragCoord.xy);
    vec4 own = parts_at(p);
    vec2 rows = vec2(own.g, parts_at(p + ivec2(0, 1)).r);  // from above, from below
    vec2 columns = vec2(own.a, parts_at(p + ivec2(1, 0)).b);  // from the left, from the right
    bool across_rows = max(rows.x, rows.y) >= max(columns.x, columns.y);
    vec2 parts = across_rows ? rows : columns;
    ivec2 back = across_rows ? ivec2(0, -1) : ivec2(-1, 0);
    o_color = picture_at(p);
    if (parts.x + parts.y == 0.0) return;
    vec4 mixed = light_at(p) * (1.0 - parts.x - parts.y) + light_at(p + back) * parts.x + light_at(p - back) * parts.y;
    o_color = vec4(srgb_from_linear(mixed.rgb), mixed.a);
}
