#include "core/log.h"

#include <algorithm>
#include <cstdio>
#include <mutex>

namespace restirpg {
namespace {

std::mutex mutex;
std::vector<std::string> warnings;

}  // namespace

void logInfo(std::string_view text)
{
    fmt::print(stderr, "{}\n", text);
}

void logWarning(std::string_view text)
{
    std::lock_guard lock(mutex);
    if (std::find(warnings.begin(), warnings.end(), text) != warnings.end())
        return;
    warnings.emplace_back(text);
    fmt::print(stderr, "warning: {}\n", text);
}

std::vector<std::string> saidWarnings()
{
    std::lock_guard lock(mutex);
    return warnings;
}

}  // namespace restirpg
