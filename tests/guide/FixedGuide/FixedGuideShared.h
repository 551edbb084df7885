// The guide's one lobe. Shared by C++ and GLSL.
#ifndef FIXED_GUIDE_SHARED_H
#define FIXED_GUIDE_SHARED_H
#include "shaders/types.h"
RESTIRPG_SHARED

struct FixedGuideLobe {
    vec3 mu;
    float kappa;
};

struct FixedGuideParameters {
    Address lobe;
    float kappa;
};

RESTIRPG_SHARED_END
#endif
