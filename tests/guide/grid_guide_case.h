// Parameters of the kernels that test the guiding grid's samplers, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_GRID_GUIDE_CASE_H
#define RESTIRPG_TEST_GRID_GUIDE_CASE_H
#include "../gpu/bsdf_case.h"
#ifdef __cplusplus
#include "shaders/guide/guiding_grid_types.h"
#else
#include "guide/guiding_grid_types.h"
#endif
RESTIRPG_SHARED

// What is drawn from.
TEST_CONST TECHNIQUE_VMF = 0u;  ///< sample_vmf about `mu`
TEST_CONST TECHNIQUE_GUIDE = 1u;  ///< guide_sample of the module
TEST_CONST TECHNIQUE_SCATTER = 2u;  ///< scatter: a BSDF and the guide

struct GridGuideCase {
    Address guide;  ///< a guide of one cell
    Address results;  ///< counts or masses, a bin each
    float alpha;
    uint technique;
    vec3 mu;
    float kappa;
    vec3 axis;  ///< of the bins: rows of equal solid angle from here on
    float height;  ///< of the cap that they cover: 1 - cos; 2: the sphere
    vec3 wo;
    float roughness;
    float metallic;
    uint seed;
};

/// Of the cell, as the test gives it.
struct TestLobe {
    vec3 mu;
    float kappa;
    float weight;
};

struct GridGuideBuild {
    Address guide;  ///< zeroed; a table of TEST_CAPACITY slots
    Address lobes;  ///< 4 TestLobe
    Address memory;  ///< one GuidingMemory
    uint options;
};

TEST_CONST TEST_CAPACITY = 64u;

RESTIRPG_SHARED_END
#endif
