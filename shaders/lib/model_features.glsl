// What effects without these features mean by not having them.
#ifndef DISTRIBUTION_BECKMANN
#define DISTRIBUTION_BECKMANN 0
#endif
#ifndef DISTRIBUTION_BLINN_PHONG
#define DISTRIBUTION_BLINN_PHONG 0
#endif
#ifndef FRESNEL_NONE
#define FRESNEL_NONE 0
#endif
#ifndef FRESNEL_DIELECTRIC
#define FRESNEL_DIELECTRIC 0
#endif
#ifndef FRESNEL_CONDUCTOR
#define FRESNEL_CONDUCTOR 0
#endif
#ifndef MASKING_IMPLICIT
#define MASKING_IMPLICIT 0
#endif
#ifndef MASKING_COOK_TORRANCE
#define MASKING_COOK_TORRANCE 0
#endif
#ifndef MASKING_SCHLICK
#define MASKING_SCHLICK 0
#endif
#ifndef MASKING_WALTER
#define MASKING_WALTER 0
#endif
#define FOREIGN_MASKING (MASKING_IMPLICIT || MASKING_COOK_TORRANCE || MASKING_SCHLICK || MASKING_WALTER)
#ifndef ENERGY_COMPENSATION
#define ENERGY_COMPENSATION 0
#endif
// Layers: effects without them have no textures of theirs either.
#ifndef CLEARCOAT
#define CLEARCOAT 0
#endif
#ifndef SHEEN
#define SHEEN 0
#endif
#ifndef ANISOTROPY
#define ANISOTROPY 0
#endif
#ifndef IRIDESCENCE
#define IRIDESCENCE 0
#endif
#ifndef TRANSMISSION
#define TRANSMISSION 0
#endif
#ifndef SPECULAR_MAP
#define SPECULAR_MAP 0
#endif
#ifndef SPECULAR_COLOR_MAP
#define SPECULAR_COLOR_MAP 0
#endif
