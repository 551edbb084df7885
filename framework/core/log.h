// Messages to standard error. A warning is said once for each distinct text.
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <vector>

namespace restirpg {

void logInfo(std::string_view text);

/// Print `warning: text` unless the same text was said before in this process.
void logWarning(std::string_view text);

/// Every distinct warning said so far, in order. Tests read it.
std::vector<std::string> saidWarnings();

template <typename... Args>
void warn(fmt::format_string<Args...> format, Args&&... args)
{
    logWarning(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace restirpg
