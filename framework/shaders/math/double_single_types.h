// Shared by C++ and GLSL: see types.h and double_single.glsl.
#ifndef RESTIRPG_DOUBLE_SINGLE_TYPES_H
#define RESTIRPG_DOUBLE_SINGLE_TYPES_H
#include "shaders/types.h"
RESTIRPG_SHARED

/// The unevaluated sum high + low, with |low| at most half a unit in the last place of high. 24 bytes.
struct DoubleSingle3 {
    vec3 high;
    vec3 low;
};

RESTIRPG_SHARED_END
#endif
