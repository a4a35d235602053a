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
