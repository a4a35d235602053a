// Points of a disc for filters, and a turn per pixel for them. Truth for both: engine/experiments/shadow_filter.py.
#include "lib/math.glsl"

// O'Neill 2014, "PCG", the 32-bit output hash: an angle per pixel that no driver computes differently.
float pixel_turn(uvec2 pixel)
{
    uint state = (pixel.x + pixel.y * 65537u) * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return float((word >> 22u) ^ word) * (2.0 * PI / 4294967296.0);
}

// Vogel 1979, "A better way to construct the sunflower head": point k has its direction a golden angle after that of
// point k - 1 (GOLDEN_TURN * direction) and this distance from the middle of a unit disc.
const mat2 GOLDEN_TURN = mat2(-0.7373688780783, 0.6754902942615, -0.6754902942615, -0.7373688780783);

float vogel_radius(int k, int count) { return sqrt((float(k) + 0.5) / float(count)); }

// Far from each other, and so are the first 8 and the first 16 of them: best candidates (Mitchell 1991, "Spectrally
// optimal sampling for distribution ray tracing"), the best of 120 tries. For pictures as the thesis has them.
const vec2 POISSON[24] = vec2[24](
    vec2(0.082917, 0.294876), vec2(-0.264459, -0.956072), vec2(-0.992203, -0.074699),
    vec2(0.805300, -0.587059), vec2(0.956973, 0.275559), vec2(-0.679137, 0.721790),
    vec2(0.521374, 0.851859), vec2(-0.326356, -0.266202), vec2(-0.096265, 0.993100),
    vec2(0.271627, -0.297973), vec2(0.308176, -0.907653), vec2(-0.773376, -0.592491),
    vec2(-0.469972, 0.233433), vec2(0.522486, 0.132631), vec2(0.961329, -0.170605),
    vec2(-0.920746, 0.359589), vec2(-0.234076, 0.591583), vec2(-0.019281, -0.618375),
    vec2(0.126478, 0.693663), vec2(0.661773, 0.508599), vec2(-0.028929, -0.064172),
    vec2(-0.639505, -0.078741), vec2(-0.393541, -0.610432), vec2(0.622057, -0.261303)
);
