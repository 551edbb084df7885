// Parameters of the BSDF test kernels, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_BSDF_CASE_H
#define RESTIRPG_TEST_BSDF_CASE_H
#ifdef __cplusplus
#include "shaders/types.h"
#else
#include "types.h"
#endif
RESTIRPG_SHARED

#ifdef __cplusplus
#define TEST_CONST constexpr uint
#else
#define TEST_CONST const uint
#endif

// Bins of a chi-square test: azimuth times polar angle.
TEST_CONST BIN_COLUMNS = 64u;
TEST_CONST BIN_ROWS = 32u;
TEST_CONST BINS = BIN_COLUMNS * BIN_ROWS;
TEST_CONST DRAWS_A_THREAD = 16u;  ///< of a sampling kernel

// What is wrong on purpose.
TEST_CONST ERROR_NONE = 0u;
TEST_CONST ERROR_ALPHA = 1u;  ///< the sampler's alpha is 5% too large
TEST_CONST ERROR_BEND = 2u;  ///< the random numbers' density rises by 10% across the unit interval
TEST_CONST ERROR_LOBE = 3u;  ///< the random number that selects the lobe is 10% too small
TEST_CONST ERROR_PDF = 4u;  ///< the pdf is 2% too large
TEST_CONST ERROR_SWAP = 5u;  ///< the roughness changes by 1% when the directions are exchanged

// How directions are binned.
TEST_CONST DOMAIN_SPHERE = 0u;  ///< wi itself
TEST_CONST DOMAIN_REFLECTION = 1u;  ///< the half vector of reflection over alpha: any lobe fills the hemisphere
TEST_CONST DOMAIN_REFRACTION = 2u;  ///< the half vector of refraction, likewise

struct BsdfCase {
    Address results;  ///< what the kernel writes
    Address inputs;  ///< what it reads besides; bsdf_values.comp only
    Address energyTable;  ///< of the material's ior; read with energy compensation only
    vec3 baseColor;
    float metallic;
    float roughness;
    float specular;
    vec3 specularColor;
    float transmission;
    float ior;
    float coatAverage;
    uint solid;
    uint entering;
    vec3 wo;
    uint lobe;  ///< one LOBE_*, or LOBE_ALL
    uint domain;  ///< DOMAIN_*
    uint seed;
    uint error;  ///< ERROR_*
};

/// Sums over one thread's draws of a furnace.
struct FurnaceSums {
    vec3 weight;
    vec3 square;
};

/// A pair of directions at which the BSDF is evaluated, and what it says.
struct DirectionPair {
    vec3 wo;
    vec3 wi;
};
struct BsdfValues {
    vec3 f;
    float pdf;
    vec3 probabilities;  ///< DIFFUSE, REFLECT, TRANSMIT
    float pdfSum;  ///< P(lobe) pdf_lobe summed one by one
    vec3 labelProbabilities;  ///< SMOOTH, SHARP_REFLECT, SHARP_TRANSMIT
    float labelPdfSum;  ///< P(label) label_pdf summed one by one
};

RESTIRPG_SHARED_END
#endif
