// Files of the per-user cache: each carries its length and checksum, so that what a full disk, a crash or a bad block
// left is made anew.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <vector>

namespace restirpg {

/// What writeCacheFile wrote; nothing when the file is missing or damaged.
std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& file);

/// Write by way of a temporary file, so that a reader sees all or nothing. Where that fails, a warning is given and the
/// program goes on.
void writeCacheFile(const std::filesystem::path& file, std::span<const std::byte> contents);

}  // namespace restirpg
