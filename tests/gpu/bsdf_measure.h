// What the BSDF tests measure of a material on the device.
#pragma once

#include "bsdf_cases.h"
#include "gpu_test.h"

namespace restirpg::test {

constexpr uint32_t THREADS = 1u << 16;  ///< of a kernel that draws DRAWS_A_THREAD directions each
constexpr double DRAWS = double(THREADS) * DRAWS_A_THREAD;

struct Histogram {
    std::vector<uint32_t> counts;
    double lost = 0;  ///< fraction of draws that carry nothing
};

/// Draws in bins.
Histogram sample(BsdfCase test);

struct Integrals {
    std::vector<double> expected;  ///< draws a bin
    double mass = 0;
    double albedo = 0;  ///< luminance of the integral of f |cos|
};

/// Integrals of the pdf over the same bins.
Integrals integrate(BsdfCase test);

/// Domain in which a lobe fills the bins.
uint32_t domainOf(const BsdfCase& test);

struct Albedo {
    glm::dvec3 mean;
    glm::dvec3 standardError;
};

/// Mean weight of draws, in power: the white furnace.
Albedo albedo(BsdfCase test, uint32_t threads = THREADS);

/// The largest relative difference of f after exchanging the directions.
double reciprocityError(BsdfCase test, uint32_t error);

}  // namespace restirpg::test
