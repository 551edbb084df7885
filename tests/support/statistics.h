// Chi-square and z tests for the statistical tests, with the correction for many comparisons.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <span>
#include <vector>

namespace restirpg::test {

/// The false-alarm rate of a whole test, split evenly over its comparisons (Bonferroni).
constexpr double FALSE_ALARM_RATE = 0.01;

inline double bonferroni(size_t comparisons)
{
    return FALSE_ALARM_RATE / double(comparisons);
}

/// P(|Z| > |z|) of a standard normal variable.
inline double twoSidedP(double z)
{
    return std::erfc(std::abs(z) / std::sqrt(2.0));
}

/// P(X > x) of a chi-square variable, by the cube-root transformation of Wilson and Hilferty (1931). At p = 1e-5 it is
/// within 12% for 5 degrees of freedom or more, which moves a threshold by far less than the statistic's own spread.
inline double chiSquareP(double x, double degrees)
{
    const double spread = 2.0 / (9.0 * degrees);
    const double z = (std::cbrt(x / degrees) - (1.0 - spread)) / std::sqrt(spread);
    return 0.5 * std::erfc(z / std::sqrt(2.0));
}

struct ChiSquare {
    double statistic = 0;
    uint32_t degrees = 0;
    double p = 1;
};

/// Pearson's test of counts against expected counts. Null hypothesis: the draws have the expected density. Cells that
/// expect fewer than 5 are pooled among themselves; a rest that still expects fewer counts as if it expected 5, which
/// is conservative. Expectations are taken as they are, not scaled to the counts: a density with the wrong mass fails.
inline ChiSquare chiSquare(std::span<const uint32_t> observed, std::span<const double> expected)
{
    constexpr double SMALLEST = 5;
    std::vector<size_t> order(observed.size());
    std::iota(order.begin(), order.end(), size_t(0));
    std::sort(order.begin(), order.end(), [&](size_t a, size_t b) { return expected[a] < expected[b]; });

    ChiSquare result;
    uint32_t cells = 0;
    double poolExpected = 0;
    double poolObserved = 0;
    const auto closePool = [&] {
        if (poolExpected > 0 || poolObserved > 0) {
            const double difference = poolObserved - poolExpected;
            result.statistic += difference * difference / std::max(poolExpected, SMALLEST);
            ++cells;
        }
        poolExpected = poolObserved = 0;
    };
    for (const size_t cell : order) {
        if (expected[cell] >= SMALLEST)
            closePool();
        poolExpected += expected[cell];
        poolObserved += observed[cell];
        if (poolExpected >= SMALLEST)
            closePool();
    }
    closePool();
    result.degrees = std::max(cells, 2u) - 1;
    result.p = chiSquareP(result.statistic, result.degrees);
    return result;
}

}  // namespace restirpg::test
