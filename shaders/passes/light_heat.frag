// Lights per tile as colours: black none, then blue to red in steps of log2; white where a list did not fit and all lights
// are meant. Of clusters, the longest list of the tile. The legend at the bottom has the numbers.
#include "lib/math.glsl"

layout(location = 0) out vec4 o_color;
#if LISTS > 0
layout(binding = 16) uniform usampler2DArray t_light_tiles;
#endif

const float MOST = 1024.0;

// Cosine palette (Quilez 1999) from blue over green to red; x in [0, 1].
vec3 heat(float x)
{
    return clamp(vec3(1.5 - abs(4.0 * x - 4.0), 1.5 - abs(4.0 * x - 2.2), 1.5 - abs(4.0 * x - 0.6)), 0.0, 1.0);
}

float share(float count) { return log2(1.0 + count) / log2(1.0 + MOST); }

// Digits, 3 x 5 cells each, a bit per cell, top row first.
const int DIGITS[10] = int[10](31599, 11415, 29671, 29647, 23497, 31183, 31215, 29257, 31727, 31695);

bool digit(int value, ivec2 at)
{
    return at.x >= 0 && at.x < 3 && at.y >= 0 && at.y < 5 && (DIGITS[value] >> (14 - (at.y * 3 + at.x)) & 1) == 1;
}

// Whether a number, its last digit ending at `right`, has ink here; `at` in cells.
bool number(int value, ivec2 at, int right)
{
    for (int k = 0; k < 4; ++k) {
        if (digit(value % 10, at - ivec2(right - 3 - 4 * k, 0))) return true;
        value /= 10;
        if (value == 0) break;
    }
    return false;
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    ivec2 size = ivec2(view.size.xy);
    uint count = 0u;
#if LISTS > 0
    for (int list = 0; list < LISTS; ++list)
        count = max(count, texelFetch(t_light_tiles, ivec3(uvec2(pixel) >> view.tiles.x, list), 0).y);
#endif
    vec3 color = count == 0u ? vec3(0.0) : count > view.counts.x ? vec3(1.0) : heat(share(float(count)));
    float alpha = 0.75;

    // legend: a bar over the width, with the counts 0, 1, 4, 16 ... below it
    int cell = max(1, size.y / 180);
    int height = 14 * cell;
    int top = size.y - height;
    if (pixel.y >= top && size.y > 4 * height) {
        alpha = 1.0;
        float x = (gl_FragCoord.x - 0.5) / max(view.size.x - 1.0, 1.0);
        float shown = exp2(x * log2(1.0 + MOST)) - 1.0;
        color = pixel.y < top + 6 * cell ? (shown < 0.5 ? vec3(0.0) : heat(x)) : vec3(0.02);
        ivec2 at = (pixel - ivec2(0, top + 8 * cell)) / cell;
        for (int value = 1; value <= 1024; value *= 4) {
            int right = int(share(float(value)) * view.size.x) / cell;
            if (pixel.y >= top + 8 * cell && number(value, at, value == 1024 ? right - 1 : right + 2)) color = vec3(0.9);
        }
        if (pixel.y >= top + 8 * cell && number(0, at, 4)) color = vec3(0.9);
    }
    o_color = vec4(color, alpha * heat_block.covers);
}
