// Parameters of bsdf_extremes.comp, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_EXTREMES_CASE_H
#define RESTIRPG_TEST_EXTREMES_CASE_H
#ifdef __cplusplus
#include "shaders/types.h"
#else
#include "types.h"
#endif
RESTIRPG_SHARED

struct ExtremesCase {
    Address results;  ///< ExtremesFound
};

/// Counts of values that are negative, infinite or no number.
struct ExtremesFound {
    uint brokenValues;
    uint brokenPdfs;
    uint brokenSamples;
    uint largestWeight;  ///< float bits: luminance of a sample's weight, as power
};

RESTIRPG_SHARED_END
#endif
