// Parameters of bsdf_sampling.comp.
#ifndef RESTIRPG_BENCH_SHARED_H
#define RESTIRPG_BENCH_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct BsdfSamplingParameters {
    Address sums;  ///< vec3, one a thread
    uint threads;
    uint samples;  ///< of each thread
    float metallic;
    float roughness;
    float transmission;
    float ior;
    float coatAverage;
    uint solid;
};

RESTIRPG_SHARED_END
#endif
