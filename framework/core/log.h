// Messages to standard error. A warning is said once for each distinct text, and of one kind no more than the first
// few.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

namespace restirpg {

/// So many warnings of a kind are said; the others are counted, and the count is said when the process ends.
constexpr size_t WARNINGS_SAID = 10;

/// `text` as it is, to standard error. What cannot be written there is lost: a terminal that was closed, or a full
/// disk, must not end the program.
void printError(std::string_view text);

void logInfo(std::string_view text);

/// Print `warning: text` in one line, unless the same text was said before in this process or WARNINGS_SAID others of
/// `kind` were.
void logWarning(std::string_view text, std::string_view kind);

/// Every distinct warning said so far, in order. Tests read it.
std::vector<std::string> saidWarnings();

/// What the warnings left out so far amount to: a line for each kind.
std::vector<std::string> omittedWarnings();

/// A warning. Those of one format and one first argument, which is the file most often, are of one kind.
template <typename First, typename... Rest>
void warn(fmt::format_string<First, Rest...> format, First&& first, Rest&&... rest)
{
    const fmt::string_view text = format;
    const auto kind = fmt::format("{}\n{}", text, first);
    logWarning(fmt::format(format, std::forward<First>(first), std::forward<Rest>(rest)...), kind);
}

}  // namespace restirpg
