// What a surface is to light from other surfaces: a layer of the deep G-buffer, without any lighting.
#define DEEP_LAYER
#include "effects/surface.frag"
