// Files appear whole or not at all.
#pragma once

#include "core/error.h"

#include <unistd.h>

#include <filesystem>

namespace restirpg {

/// A name beside `file` that no other process uses; throws Error when the folder is missing.
inline std::filesystem::path temporaryName(const std::filesystem::path& file)
{
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    if (!std::filesystem::is_directory(folder))
        fail("{}: cannot write: the folder {} does not exist; create it first", file.string(), folder.string());
    if (std::filesystem::is_directory(file))
        fail("{}: cannot write: it is a folder; name a file", file.string());
    // Extension kept last: image libraries choose the codec by it.
    return folder / fmt::format(".{}.{}.tmp{}", file.stem().string(), getpid(), file.extension().string());
}

/// `write(path)` is given a temporary name in the same folder; the file gets its final name when `write` returns and is
/// removed when it throws. Throws Error naming `file` when the folder does not exist or cannot be written.
template <typename Write>
void writeAtomically(const std::filesystem::path& file, Write&& write)
{
    const auto temporary = temporaryName(file);
    std::error_code ignored;
    try {
        write(temporary);
        std::filesystem::rename(temporary, file);
    } catch (const Error&) {
        std::filesystem::remove(temporary, ignored);
        throw;
    } catch (const std::exception& error) {
        std::filesystem::remove(temporary, ignored);
        fail("{}: cannot write: {}", file.string(), error.what());
    }
}

}  // namespace restirpg
