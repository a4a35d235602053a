// All shadow maps of the frame, side by side over the picture: the sun's cascades, then the map that local lights share.
// Depth as grey: white towards the light. In the lights' map by the logarithm of the distance, from a decimetre to a hundred
// metres.
layout(location = 0) out vec4 o_color;
layout(location = 0) in vec2 v_uv;
layout(binding = 11) uniform sampler2DArray t_cascades;
layout(binding = 15) uniform sampler2D t_lamps;

void main()
{
    // squares in rows, as large as the picture has room for
    int count = int(maps.cascades + maps.lamps);
    float aspect = view.size.x * view.size.w;
    float columns = 1.0;
    while (columns < 64.0 && ceil(float(count) / columns) * aspect > columns) columns += 1.0;
    float side = 1.0 / columns;  // of the picture's width
    vec2 at = vec2(v_uv.x, v_uv.y / aspect) / side;
    ivec2 cell = ivec2(floor(at));
    int index = cell.x + cell.y * int(columns);
    vec2 uv = (fract(at) - 0.02) / 0.96;
    bool inside = index < count && cell.x < int(columns) && all(greaterThanEqual(uv, vec2(0.0))) && all(lessThan(uv, vec2(1.0)));
    vec3 color = vec3(0.0);
    if (inside && index < int(maps.cascades)) {
        float d = textureLod(t_cascades, vec3(uv, float(index)), 0.0).r;
        color = d > 0.0 ? vec3(0.03 + 0.97 * d) : vec3(0.0, 0.0, 0.05);
    } else if (inside) {
        float d = textureLod(t_lamps, uv, 0.0).r;
        color = d > 0.0 ? vec3(clamp(0.667 - 0.3333 * log2(1e-6 / d) / log2(10.0), 0.03, 1.0)) : vec3(0.0, 0.0, 0.05);
    }
    o_color = vec4(color, maps.covers);
}
