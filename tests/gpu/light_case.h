// Parameters of the light test kernels, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_LIGHT_CASE_H
#define RESTIRPG_TEST_LIGHT_CASE_H
#ifdef __cplusplus
#include "shaders/frame_types.h"
#else
#include "frame_types.h"
#endif
#include "bsdf_case.h"
RESTIRPG_SHARED

// What is sampled.
TEST_CONST SAMPLE_LIGHTS = 0u;  ///< sample_light
TEST_CONST SAMPLE_ENVIRONMENT = 1u;  ///< sample_environment alone

TEST_CONST MAX_TEST_LIGHTS = 1024u;

struct LightCase {
    Address frame;
    Address results;  ///< what the kernel writes
    Address inputs;  ///< what it reads besides; light_values.comp only
    vec3 x;  ///< the point that is lit
    uint technique;  ///< SAMPLE_*
    uint seed;
    uint error;  ///< ERROR_*
};

/// What light_sample.comp counts.
struct LightCounts {
    uint bins[BINS];  ///< directions of samples that are no deltas
    uint lights[MAX_TEST_LIGHTS];  ///< samples of each light
    uint deltas;
    uint empty;  ///< samples with pdf 0
    uint worstPdf;  ///< float bits: of a triangle's sample, largest relative difference of its pdf and MIS's
};

/// Sums over one thread's draws.
struct LightSums {
    float radiance;  ///< luminance / pdf, of samples that are no deltas
    float square;
};

/// A light that is no environment, seen from x, and a direction of the sky.
struct LightQuery {
    vec3 x;
    uint light;
    vec2 barycentrics;
    vec3 direction;
};
struct LightValues {
    vec3 wi;
    float distance;
    vec3 radiance;
    float pdf;
    vec3 environment;  ///< radiance from `direction`
    vec2 uv;  ///< of `direction`
    vec3 roundTrip;  ///< the direction of `uv`
};

RESTIRPG_SHARED_END
#endif
