// The standard surface with a choice of D, F and V.
#include "effects/surface.frag"
#include "lib/surface_model.glsl"
