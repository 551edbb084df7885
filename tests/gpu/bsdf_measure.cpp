#include "bsdf_measure.h"

#include <bit>

namespace restirpg::test {

using glm::dvec3;

Histogram sample(BsdfCase test)
{
    const Buffer counters = device().createBuffer((BINS + 1) * sizeof(uint32_t), "counters");
    test.results = counters.address();
    run("bsdf_sample", test, THREADS);
    Histogram histogram;
    histogram.counts = device().download<uint32_t>(counters, BINS + 1);
    histogram.lost = histogram.counts.back() / DRAWS;
    histogram.counts.pop_back();
    return histogram;
}

Integrals integrate(BsdfCase test)
{
    const Buffer values = device().createBuffer(BINS * sizeof(glm::vec2), "integrals");
    test.results = values.address();
    run("bsdf_integrate", test, BINS);
    Integrals integrals;
    for (const glm::vec2& bin : device().download<glm::vec2>(values, BINS)) {
        integrals.expected.push_back(bin.x * DRAWS);
        integrals.mass += bin.x;
        integrals.albedo += bin.y;
    }
    return integrals;
}

uint32_t domainOf(const BsdfCase& test)
{
    if (test.lobe == LOBE_DIFFUSE || test.lobe == LOBE_ALL)
        return DOMAIN_SPHERE;
    return test.lobe == LOBE_TRANSMIT && test.solid ? DOMAIN_REFRACTION : DOMAIN_REFLECTION;
}

Albedo albedo(BsdfCase test, uint32_t threads)
{
    const Buffer results = device().createBuffer(threads * sizeof(FurnaceSums), "sums");
    test.results = results.address();
    test.seed = 77;
    run("bsdf_furnace", test, threads);
    dvec3 sum(0), square(0);
    for (const FurnaceSums& thread : device().download<FurnaceSums>(results, threads)) {
        sum += dvec3(thread.weight);
        square += dvec3(thread.square);
    }
    const double draws = double(threads) * DRAWS_A_THREAD;
    const dvec3 mean = sum / draws;
    return {mean, glm::sqrt(glm::max(square / draws - mean * mean, dvec3(0)) / draws)};
}

double reciprocityError(BsdfCase test, uint32_t error)
{
    const Buffer results = device().createBuffer(2 * sizeof(uint32_t), "reciprocity");
    test.results = results.address();
    test.error = error;
    test.seed = 5;
    run("bsdf_reciprocity", test, 1u << 16);
    const auto words = device().download<uint32_t>(results, 2);
    EXPECT_GT(words[1], 1000u) << "too few pairs of directions were tried";
    return std::bit_cast<float>(words[0]);
}

}  // namespace restirpg::test
