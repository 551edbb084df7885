// How much memory may be taken, asked before it is taken: what a hostile file's header claims must not end in the
// machine's out-of-memory killer.
#pragma once

#include <cstdint>
#include <filesystem>
#include <istream>
#include <string>

namespace restirpg {

/// Bytes that this process can still take without swapping: the least of what the machine has free
/// (/proc/meminfo's MemAvailable), of what its control groups leave and of what `ulimit -v` leaves.
uint64_t availableMemory();

/// Bytes that the control groups of a process leave, of versions 2 and 1, with all groups above them. Cached files
/// count as left: they give way. `root`: where groups are (/sys/fs/cgroup). `membership`: what /proc/self/cgroup says.
/// The largest number where there is no limit.
uint64_t groupMemoryLeft(const std::filesystem::path& root, std::istream& membership);

/// Bytes of address space that `ulimit -v` leaves; the largest number where there is no limit.
uint64_t addressSpaceLeft();

/// Bytes that one thing read from a file (an image, a mesh) may take: half of what is available.
uint64_t memoryBudget();

/// Throws Error "PLACE: WHAT needs 3.2 GiB of memory, of which 1.0 GiB may be taken here; MEND" when `bytes` exceed
/// `memoryBudget()`.
void checkMemory(const std::string& place, const std::string& what, uint64_t bytes, const std::string& mend);

/// "3.2 GiB".
std::string bytesText(uint64_t bytes);

}  // namespace restirpg
