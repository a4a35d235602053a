// Light in steps, as drawn by hand.
#include "effects/surface.frag"
#include "lib/toon.glsl"
