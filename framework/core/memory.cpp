#include "core/memory.h"

#include "core/error.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>

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

/// The files of a version of control groups that tell of memory.
struct GroupFiles {
    const char* limit;
    const char* used;
    std::array<std::string_view, 2> cached;  ///< keys of memory.stat, of a group and all below it
};
constexpr GroupFiles VERSION_2 = {"memory.max", "memory.current", {"inactive_file", "active_file"}};
constexpr GroupFiles VERSION_1 = {
    "memory.limit_in_bytes", "memory.usage_in_bytes", {"total_inactive_file", "total_active_file"}};

uint64_t cachedBytes(const fs::path& group, const GroupFiles& files)
{
    std::ifstream stream(group / "memory.stat");
    std::string key;
    uint64_t number = 0, sum = 0;
    while (stream >> key >> number)
        if (std::find(files.cached.begin(), files.cached.end(), key) != files.cached.end())
            sum += number;
    return sum;
}

uint64_t leftInGroup(const fs::path& group, const GroupFiles& files)
{
    const uint64_t most = numberIn(group / files.limit, UNLIMITED);
    if (most == UNLIMITED)
        return UNLIMITED;
    const uint64_t used = numberIn(group / files.used, 0);
    const uint64_t kept = used - std::min(used, cachedBytes(group, files));
    return most - std::min(most, kept);
}

/// The least that `group`, a path below `root` as /proc/self/cgroup has it, and those above it leave. Inside a
/// container the path may be one that is not there: the root tells then.
uint64_t leftUpTo(const fs::path& root, const std::string& group, const GroupFiles& files)
{
    uint64_t least = leftInGroup(root, files);
    for (fs::path at = fs::path(group).relative_path(); !at.empty(); at = at.parent_path())
        least = std::min(least, leftInGroup(root / at, files));
    return least;
}

uint64_t groupLeaves()
{
    std::ifstream membership("/proc/self/cgroup");
    return groupMemoryLeft("/sys/fs/cgroup", membership);
}

}  // namespace

uint64_t groupMemoryLeft(const fs::path& root, std::istream& membership)
{
    std::string group2, group1;
    for (std::string line; std::getline(membership, line);) {
        if (line.starts_with("0::"))
            group2 = line.substr(3);
        else if (const auto found = line.find(":memory:"); found != line.npos)
            group1 = line.substr(found + 8);
    }
    return std::min(leftUpTo(root, group2, VERSION_2), leftUpTo(root / "memory", group1, VERSION_1));
}

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
