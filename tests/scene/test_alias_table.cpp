// The alias method: draws, and the probabilities that it reports.
#include "gltf_builder.h"

#include "../support/statistics.h"
#include "scene/lights.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <random>

using namespace restirpg;

namespace {

/// The p of Pearson's test of so many alias draws against `pmf`.
double pOfDraws(const std::vector<AliasColumn>& table, const std::vector<float>& pmf, int draws)
{
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(0, 1);
    std::uniform_int_distribution<uint32_t> column(0, uint32_t(table.size() - 1));
    std::vector<uint32_t> hits(table.size());
    for (int i = 0; i < draws; ++i) {
        const uint32_t c = column(random);
        ++hits[uniform(random) < table[c].threshold ? c : table[c].alias];
    }
    std::vector<double> expected(pmf.begin(), pmf.end());
    for (double& count : expected)
        count *= draws;
    return test::chiSquare(hits, expected).p;
}

/// Weights over eleven orders of magnitude, zeros between.
std::vector<double> wildWeights(size_t n)
{
    std::mt19937 random(7);
    std::uniform_real_distribution<double> exponent(-6, 5);
    std::vector<double> weights(n);
    for (size_t i = 0; i < n; ++i)
        weights[i] = i % 5 == 3 ? 0 : std::pow(10, exponent(random));
    return weights;
}

}  // namespace

/// H0: the table draws column i with probability pmf[i]; 2^20 samples, 64 cells of which 51 are reachable; a false
/// alarm in 10^6.
TEST(AliasTable, DrawsFollowThePmfItReports)
{
    const auto weights = wildWeights(64);
    std::vector<float> pmf;
    const auto table = buildAliasTable(weights, pmf);
    EXPECT_GT(pOfDraws(table, pmf, 1 << 20), 1e-6);

    auto wrong = table;
    for (auto& column : wrong)
        column.threshold = std::min(1.0f, column.threshold + 0.01f);
    EXPECT_LT(pOfDraws(wrong, pmf, 1 << 20), 1e-6) << "an error of 0.01 in the thresholds must show";
}

TEST(AliasTable, ThePmfIsTheOneTheFloatsRealiseAndTheWeightsAsk)
{
    const auto weights = wildWeights(1000);
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    std::vector<float> pmf;
    const auto table = buildAliasTable(weights, pmf);
    std::vector<double> realised(weights.size());
    for (size_t i = 0; i < table.size(); ++i) {
        realised[i] += double(table[i].threshold) / 1000;
        realised[table[i].alias] += (1 - double(table[i].threshold)) / 1000;
    }
    for (size_t i = 0; i < weights.size(); ++i) {
        EXPECT_EQ(pmf[i], float(realised[i]));
        EXPECT_NEAR(pmf[i], weights[i] / sum, 1e-7);
        EXPECT_EQ(pmf[i] == 0, weights[i] == 0) << i;
    }
}

/// Kernels compare the threshold with a fraction of 24 bits: of a lamp beside a sun, too, the pmf has to be how often
/// it is drawn.
TEST(AliasTable, ThePmfOfDimLightsIsHowOftenTheyAreDrawn)
{
    constexpr double FRACTIONS = 0x1p24;
    for (const double dim : {12.6, 1.3e3, 1.3e5}) {
        const std::vector<double> weights{dim, 3.1e9, 40 * dim};
        std::vector<float> pmf;
        const auto table = buildAliasTable(weights, pmf);
        std::vector<double> drawn(weights.size());
        for (const auto& column : table) {
            const double own = std::ceil(double(column.threshold) * FRACTIONS);  // fractions below it
            drawn[&column - table.data()] += own / FRACTIONS / 3;
            drawn[column.alias] += (FRACTIONS - own) / FRACTIONS / 3;
        }
        for (size_t i = 0; i < weights.size(); ++i)
            EXPECT_EQ(pmf[i], float(drawn[i])) << i << " of " << dim;
    }
}

TEST(AliasTable, EqualWeightsNeedNoAlias)
{
    std::vector<float> pmf;
    for (const auto& column : buildAliasTable(std::vector<double>(7, 0.1), pmf))
        EXPECT_EQ(column.threshold, 1);
    for (const float p : pmf)
        EXPECT_FLOAT_EQ(p, 1.0f / 7);
}

TEST(AliasTable, UselessWeightsAreErrors)
{
    std::vector<float> pmf;
    for (const auto& weights : {std::vector<double>{}, {0, 0}, {1, -1, 3}, {1, INFINITY}, {NAN, 1}})
        EXPECT_FALSE(errorOf([&] { buildAliasTable(weights, pmf); }).empty());
}
