#include "core/memory.h"

#include "core/error.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>

#include <sys/resource.h>
#include <unistd.h>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t UNLIMITED = std::numeric_limits<uint64_t>::max();

/// The number that a file of one number begins with; "max" and a missing file are no limit.
uint64_t numberIn(const fs::path& file, uint64_t otherwise)
{
    uint64_t number = 0;
    std::ifstream stream(file);
    return stream >> number ? number : otherwise;
}

uint64_t machineLeaves()
{
    std::ifstream stream("/proc/meminfo");
    std::string key, unit;
    uint64_t kibibytes = 0;
    while (stream >> key >> kibibytes) {
        if (key == "MemAvailable:")
            return kibibytes * 1024;
        std::getline(stream, unit);
    }
    return uint64_t(sysconf(_SC_PHYS_PAGES)) * uint64_t(sysconf(_SC_PAGESIZE));
}

/// Of the control group that this process is in, versions 2 and 1. Inside a container its group is the root.
uint64_t groupLeaves()
{
    const fs::path root = "/sys/fs/cgroup";
    std::array<fs::path, 2> groups{root, root};
    std::ifstream stream("/proc/self/cgroup");
    for (std::string line; std::getline(stream, line);)
        if (line.rfind("0::/", 0) == 0)
            groups[1] = root / line.substr(4);
    uint64_t least = UNLIMITED;
    const auto take = [&](const fs::path& limit, const fs::path& used) {
        const uint64_t most = numberIn(limit, UNLIMITED);
        if (most != UNLIMITED)
            least = std::min(least, most - std::min(most, numberIn(used, 0)));
    };
    for (const auto& group : groups)
        take(group / "memory.max", group / "memory.current");
    take(root / "memory/memory.limit_in_bytes", root / "memory/memory.usage_in_bytes");
    return least;
}

}  // namespace

uint64_t addressSpaceLeft()
{
    rlimit limit{};
    if (getrlimit(RLIMIT_AS, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY)
        return UNLIMITED;
    const uint64_t used = numberIn("/proc/self/statm", 0) * uint64_t(sysconf(_SC_PAGESIZE));
    return limit.rlim_cur - std::min<uint64_t>(limit.rlim_cur, used);
}

uint64_t availableMemory()
{
    return std::min({machineLeaves(), groupLeaves(), addressSpaceLeft()});
}

uint64_t memoryBudget()
{
    return availableMemory() / 2;
}

void checkMemory(const std::string& place, const std::string& what, uint64_t bytes, const std::string& mend)
{
    // Asking costs tens of microseconds; what fits anywhere needs no asking.
    constexpr uint64_t SMALL = 1 << 20;
    if (bytes <= SMALL)
        return;
    const uint64_t budget = memoryBudget();
    if (bytes > budget)
        fail("{}: {} needs {} of memory, of which {} may be taken here; {}", place, what, bytesText(bytes),
             bytesText(budget), mend);
}

std::string bytesText(uint64_t bytes)
{
    static const std::array<const char*, 5> UNITS = {"bytes", "KiB", "MiB", "GiB", "TiB"};
    double value = double(bytes);
    size_t unit = 0;
    for (; value >= 1024 && unit + 1 < UNITS.size(); ++unit)
        value /= 1024;
    return fmt::format("{:.{}f} {}", value, unit == 0 ? 0 : 1, UNITS[unit]);
}

}  // namespace restirpg
