// What an image file may claim before memory is taken for it.
#pragma once

#include "core/error.h"

#include <cstdint>
#include <filesystem>

namespace restirpg {

constexpr uint64_t MAX_IMAGE_SIDE = 65536;
constexpr uint64_t MAX_IMAGE_PIXELS = 1ull << 28;
/// Pixels a byte of a file may stand for. The best codecs reach about 3000 on a constant image; a hostile header claims
/// more.
constexpr uint64_t MAX_PIXELS_PER_BYTE = 1ull << 14;

/// Throws Error naming `file` when width x height is empty, absurd, or more than a file of `bytes` bytes can hold.
inline void checkImageClaim(const std::filesystem::path& file, int64_t width, int64_t height, uint64_t bytes)
{
    if (width <= 0 || height <= 0)
        fail("{}: cannot read: the image is empty ({}x{}); give a file with pixels", file.string(), width, height);
    const uint64_t pixels = uint64_t(width) * uint64_t(height);
    if (uint64_t(width) > MAX_IMAGE_SIDE || uint64_t(height) > MAX_IMAGE_SIDE || pixels > MAX_IMAGE_PIXELS)
        fail("{}: cannot read: the header claims {}x{} pixels, more than the limit of {} pixels; scale the image down "
             "or mend "
             "the header",
             file.string(), width, height, MAX_IMAGE_PIXELS);
    if (pixels / MAX_PIXELS_PER_BYTE > bytes)
        fail("{}: cannot read: the header claims {}x{} pixels but the file has only {} bytes; it is damaged or "
             "truncated, "
             "write it again",
             file.string(), width, height, bytes);
}

}  // namespace restirpg
