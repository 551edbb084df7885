#include "core/log.h"

#include "core/error.h"

#include <cstdio>
#include <cstdlib>
#include <functional>
#include <map>
#include <mutex>
#include <unordered_set>

namespace restirpg {
namespace {

struct Kind {
    std::string first;  ///< the first warning of the kind
    size_t said = 0;
    size_t omitted = 0;
};

std::mutex mutex;
std::vector<std::string> warnings;
std::unordered_set<size_t> seen;  ///< hashes of the texts, said or omitted
std::map<std::string, Kind, std::less<>> kinds;

void sayOmitted()
{
    for (const auto& line : omittedWarnings())
        printError(fmt::format("warning: {}\n", line));
}

}  // namespace

void printError(std::string_view text)
{
    std::fwrite(text.data(), 1, text.size(), stderr);
}

void logInfo(std::string_view text)
{
    printError(escaped(text, Breaks::kept) + "\n");
}

void logWarning(std::string_view text, std::string_view kindName)
{
    std::lock_guard lock(mutex);
    const std::string line = escaped(text);
    if (!seen.insert(std::hash<std::string>()(line)).second)
        return;
    Kind& kind = kinds[std::string(kindName)];
    if (kind.said == WARNINGS_SAID) {
        static const int registered = std::atexit(sayOmitted);
        (void)registered;
        ++kind.omitted;
        return;
    }
    if (kind.said++ == 0)
        kind.first = line;
    warnings.push_back(line);
    printError(fmt::format("warning: {}\n", line));
}

std::vector<std::string> saidWarnings()
{
    std::lock_guard lock(mutex);
    return warnings;
}

std::vector<std::string> omittedWarnings()
{
    std::lock_guard lock(mutex);
    std::vector<std::string> lines;
    for (const auto& [name, kind] : kinds)
        if (kind.omitted > 0)
            lines.push_back(fmt::format("{} more like: {}", kind.omitted, kind.first));
    return lines;
}

}  // namespace restirpg
