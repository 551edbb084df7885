#include "statistics.h"

#include <gtest/gtest.h>

#include <random>

using namespace restirpg::test;

TEST(Statistics, ChiSquareTailMatchesTables)
{
    // Quantiles from the standard table (Abramowitz & Stegun 26.8).
    EXPECT_NEAR(chiSquareP(18.307, 10), 0.05, 1e-3);
    EXPECT_NEAR(chiSquareP(29.588, 10), 0.001, 1e-4);
    EXPECT_NEAR(chiSquareP(124.342, 100), 0.05, 5e-4);
    EXPECT_NEAR(chiSquareP(149.449, 100), 0.001, 2e-5);
    EXPECT_NEAR(twoSidedP(1.959964), 0.05, 1e-6);
}

TEST(Statistics, ChiSquareAcceptsTheDensityAndRejectsOneThatIsTwoPercentOff)
{
    std::mt19937_64 generator(1);
    std::vector<uint32_t> counts(1024);
    for (int draw = 0; draw < 4'000'000; ++draw)
        ++counts[generator() >> 54];
    std::vector<double> expected(counts.size(), 4e6 / 1024);
    EXPECT_GT(chiSquare(counts, expected).p, bonferroni(1));
    for (size_t cell = 0; cell < expected.size(); ++cell)
        expected[cell] *= cell % 2 == 0 ? 1.02 : 0.98;
    EXPECT_LT(chiSquare(counts, expected).p, 1e-6);
}

TEST(Statistics, DrawsWhereNothingIsExpectedAreRejected)
{
    const std::vector<uint32_t> counts{10000, 10000, 50};
    const std::vector<double> expected{10000, 10000, 0};
    EXPECT_LT(chiSquare(counts, expected).p, 1e-6);
}
