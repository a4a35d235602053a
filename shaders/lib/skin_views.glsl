// Views of a skin's weights, computed per vertex; numbers as in engine/render/settings.py.

#define VIEW_WEIGHTS (DEBUG_VIEW == 19)
#define VIEW_INFLUENCES (DEBUG_VIEW == 20)
#define VIEW_OF_SKIN (VIEW_WEIGHTS || VIEW_INFLUENCES)

const vec3 NO_SKIN = vec3(0.18);

// Neighbouring joints differ most: hues a golden angle apart, in three rows of lightness.
vec3 joint_color(uint joint)
{
    float hue = fract(float(joint) * 0.6180339887);
    vec3 rgb = clamp(abs(fract(hue + vec3(0.0, 2.0, 1.0) / 3.0) * 6.0 - 3.0) - 1.0, 0.0, 1.0);
    return mix(vec3(0.5), rgb, 0.85) * (0.55 + 0.2 * float(joint % 3u));
}

// Told apart by those who do not tell red from green, too: colours of Okabe and Ito 2008, "Color Universal Design".
vec3 count_color(int count)
{
    if (count <= 1) return vec3(0.0, 0.168, 0.445);
    if (count == 2) return vec3(0.0, 0.342, 0.171);
    if (count == 3) return vec3(0.871, 0.775, 0.054);
    if (count == 4) return vec3(0.665, 0.112, 0.0);
    return vec3(0.604, 0.191, 0.386);
}
