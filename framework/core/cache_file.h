// Files of the per-user cache: each carries its length and checksum, so that what a full disk, a crash or a bad block
// left is made anew.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

namespace restirpg {

/// FNV-1a, 64 bits, of all that was added. Texts are told apart from their concatenation.
class Hash {
public:
    void add(const void* data, size_t bytes);
    void add(std::string_view text);
    uint64_t value() const { return value_; }

private:
    uint64_t value_ = 0xcbf29ce484222325ull;
};

/// What writeCacheFile wrote; nothing when the file is missing or damaged.
std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& file);

/// Write by way of a temporary file, so that a reader sees all or nothing. Where that fails, a warning is given and the
/// program goes on.
void writeCacheFile(const std::filesystem::path& file, std::span<const std::byte> contents);

}  // namespace restirpg
