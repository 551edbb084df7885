// "Did you mean": the nearest of the names there are.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace restirpg {

/// Levenshtein distance: insertions, deletions and substitutions of one character.
size_t editDistance(std::string_view a, std::string_view b);

/// The candidate nearest to `name`, the first of equals; empty when none shares half of its letters with `name`.
std::string nearest(std::string_view name, const std::vector<std::string>& candidates);

/// "did you mean 'x'?" for the nearest candidate, or empty.
std::string didYouMean(std::string_view name, const std::vector<std::string>& candidates);

}  // namespace restirpg
