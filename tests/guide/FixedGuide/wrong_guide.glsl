#define DENSITY_FACTOR 0.9
#include "guide.glsl"
