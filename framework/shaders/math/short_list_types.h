// The size of a ShortList. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_SHORT_LIST_TYPES_H
#define RESTIRPG_SHORT_LIST_TYPES_H
#include "shaders/types.h"
RESTIRPG_SHARED

RESTIRPG_CONST SHORT_LIST_SIZE = 16u;  ///< words: four vectors of four

RESTIRPG_SHARED_END
#endif
