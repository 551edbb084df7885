// The kernel's parameters. Shared by C++ and GLSL.
#ifndef EXPOSURE_SHARED_H
#define EXPOSURE_SHARED_H
#ifdef __cplusplus
#include "shaders/types.h"
#else
#include "types.h"
#endif
RESTIRPG_SHARED

struct ExposureParams {
    Address radiance;  ///< Image3
    Address image;  ///< Image3
    uvec2 size;  ///< pixels
    float scale;  ///< 2^stops
};

RESTIRPG_SHARED_END
#endif
