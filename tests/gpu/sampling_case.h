// Parameters of sampling.comp, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_SAMPLING_CASE_H
#define RESTIRPG_TEST_SAMPLING_CASE_H
#ifdef __cplusplus
#include "shaders/types.h"
#else
#include "types.h"
#endif
RESTIRPG_SHARED

struct SamplingCase {
    Address results;  ///< SamplingWorst
};

/// The largest violations found, as float bits.
struct SamplingWorst {
    uint basis;  ///< make_frame: deviation from an orthonormal, right-handed frame about n
    uint roundTrip;  ///< to_world(to_local(w)) - w
    uint cosineLength;  ///< sample_cosine_hemisphere: deviation of the length from 1; 1 when z <= 0
    uint alias;  ///< draw_alias: deviation of column and fraction from the number drawn; 1 when out of range
};

RESTIRPG_SHARED_END
#endif
