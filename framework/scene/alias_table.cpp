#include "core/error.h"
#include "scene/lights.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace restirpg {

namespace {

/// Kernels compare a threshold with a fraction of 24 bits: it is one of those, and above 0 where the weight is.
float drawable(double p)
{
    constexpr double FRACTIONS = 0x1p24;
    return float(std::ceil(p * FRACTIONS) / FRACTIONS);
}

}  // namespace

/// Vose's construction, "A linear algorithm for generating random numbers with a given distribution", 1991.
std::vector<AliasColumn> buildAliasTable(std::span<const double> weights, std::vector<float>& pmf)
{
    double sum = 0;
    for (const double weight : weights)
        sum += weight;
    if (weights.empty() || weights.size() > std::numeric_limits<uint32_t>::max() || !(sum > 0) || !std::isfinite(sum) ||
        *std::min_element(weights.begin(), weights.end()) < 0)
        fail("alias table: weights must be finite, at least 0 and not all 0");

    const size_t n = weights.size();
    std::vector<AliasColumn> table(n);
    std::vector<double> scaled(n);
    std::vector<uint32_t> small, large;
    for (size_t i = 0; i < n; ++i) {
        scaled[i] = weights[i] / sum * double(n);
        (scaled[i] < 1 ? small : large).push_back(uint32_t(i));
    }
    while (!small.empty() && !large.empty()) {
        const uint32_t poor = small.back(), rich = large.back();
        small.pop_back();
        table[poor] = {drawable(scaled[poor]), rich};
        scaled[rich] -= 1 - scaled[poor];
        if (scaled[rich] < 1) {
            large.pop_back();
            small.push_back(rich);
        }
    }
    // What rounding leaves over is 1 but for the last bits; a weight of 0 must stay unreachable even so.
    const auto heaviest = uint32_t(std::max_element(weights.begin(), weights.end()) - weights.begin());
    for (const auto* rest : {&small, &large})
        for (const uint32_t i : *rest)
            table[i] = {weights[i] > 0 ? 1.0f : 0.0f, heaviest};

    std::vector<double> realised(n);
    for (size_t i = 0; i < n; ++i) {
        realised[i] += table[i].threshold;
        realised[table[i].alias] += 1 - double(table[i].threshold);
    }
    pmf.resize(n);
    std::transform(realised.begin(), realised.end(), pmf.begin(), [&](double p) { return float(p / double(n)); });
    return table;
}

}  // namespace restirpg
