#include "core/nearest.h"

#include <algorithm>
#include <numeric>

namespace restirpg {

size_t editDistance(std::string_view a, std::string_view b)
{
    // One row of the dynamic programming table at a time.
    std::vector<size_t> row(b.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (size_t i = 1; i <= a.size(); ++i) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b.size(); ++j) {
            const size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row.back();
}

std::string nearest(std::string_view name, const std::vector<std::string>& candidates)
{
    std::string best;
    size_t bestDistance = 0;
    for (const auto& candidate : candidates) {
        const size_t distance = editDistance(name, candidate);
        if (2 * distance <= std::max(name.size(), candidate.size()) && (best.empty() || distance < bestDistance)) {
            best = candidate;
            bestDistance = distance;
        }
    }
    return best;
}

std::string didYouMean(std::string_view name, const std::vector<std::string>& candidates)
{
    const auto candidate = nearest(name, candidates);
    return candidate.empty() ? std::string() : "did you mean '" + candidate + "'?";
}

}  // namespace restirpg
