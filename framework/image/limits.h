// What an image file may claim before memory is taken for it.
#pragma once

#include "core/error.h"
#include "core/memory.h"

#include <cstdint>
#include <string>

namespace restirpg {

constexpr uint64_t MAX_IMAGE_SIDE = 65536;

/// Memory that a pixel takes at the peak, from the decoder to the device: decoded as RGBA, copied for the transfer and
/// stored on the device (which on the CPU is the same memory).
constexpr uint64_t BYTES_PER_PIXEL_8 = 16;  ///< 4 bytes each, and a progressive JPEG's coefficients
constexpr uint64_t BYTES_PER_PIXEL_16 = 56;  ///< 8 bytes decoded, then as float
constexpr uint64_t BYTES_PER_PIXEL_FLOAT = 60;  ///< 12 bytes decoded, then 16 each

/// Pixels a byte of a file may stand for. The best codecs reach about 10,000 on a constant image, and small ones of
/// these are in use. Nobody keeps a constant image of more than LARGE_IMAGE pixels (8192 x 8192): there more than 64
/// are a forged header or a decompression bomb. Real images have less than 10.
constexpr uint64_t MAX_PIXELS_PER_BYTE = 1ull << 14;
constexpr uint64_t MAX_PIXELS_PER_BYTE_LARGE = 64;
constexpr uint64_t LARGE_IMAGE = 1ull << 26;

/// Throws Error that begins with `place` when width x height is empty, absurd, more than an image file of `bytes` bytes
/// can hold, or needs more memory than the machine has to spare.
inline void checkImageClaim(const std::string& place, int64_t width, int64_t height, uint64_t bytes,
                            uint64_t bytesPerPixel)
{
    if (width <= 0 || height <= 0)
        fail("{}: cannot read: the image is empty ({}x{}); give a file with pixels", place, width, height);
    if (uint64_t(width) > MAX_IMAGE_SIDE || uint64_t(height) > MAX_IMAGE_SIDE)
        fail("{}: cannot read: the header claims {}x{} pixels, more than the limit of {} a side; scale the image down "
             "or mend the header",
             place, width, height, MAX_IMAGE_SIDE);
    const uint64_t pixels = uint64_t(width) * uint64_t(height);
    if (pixels / (pixels > LARGE_IMAGE ? MAX_PIXELS_PER_BYTE_LARGE : MAX_PIXELS_PER_BYTE) > bytes)
        fail("{}: cannot read: the header claims {}x{} pixels but the file has only {} bytes; it is damaged, truncated "
             "or a decompression bomb; scale the image down or write it again",
             place, width, height, bytes);
    checkMemory(place + ": cannot read", fmt::format("an image of {}x{} pixels", width, height), pixels * bytesPerPixel,
                "scale the image down or use a machine with more memory");
}

}  // namespace restirpg
