// JPEG through libjpeg-turbo. (stb_image's decoder writes past its Huffman tables on forged files.)
#include "scene/gltf_file.h"

#include <csetjmp>
#include <cstdio>
#include <memory>

#include <jpeglib.h>

namespace restirpg::gltf {

namespace {

/// libjpeg reports a fatal error by a callback that must not return.
struct ErrorManager {
    jpeg_error_mgr base;
    jpeg_progress_mgr progress;
    std::jmp_buf escape;
    char message[JMSG_LENGTH_MAX];  ///< the error, or the first warning
};

ErrorManager& managerOf(j_common_ptr codec)
{
    return *reinterpret_cast<ErrorManager*>(codec->err);
}

void escapeWithMessage(j_common_ptr codec)
{
    codec->err->format_message(codec, managerOf(codec).message);
    std::longjmp(managerOf(codec).escape, 1);
}

/// Level -1 is a warning about corrupt data; the others are trace messages.
void keepWarning(j_common_ptr codec, int level)
{
    if (level < 0 && codec->err->num_warnings++ == 0)
        codec->err->format_message(codec, managerOf(codec).message);
}

/// Every scan of a progressive file goes over the whole image, and a scan may be a few bytes long. 67 million pixels
/// may have 32 scans, and 1024 x 1024 have 2048.
constexpr uint64_t MAX_SCANNED_PIXELS = 1ull << 31;
/// As many an image of any size may have. Encoders write about 10.
constexpr uint64_t USUAL_SCANS = 16;

void limitScans(j_common_ptr codec)
{
    const auto& image = *reinterpret_cast<j_decompress_ptr>(codec);
    if (!hasTooManyScans(uint64_t(image.input_scan_number), image.image_width, image.image_height))
        return;
    std::snprintf(managerOf(codec).message, sizeof managerOf(codec).message, "it has too many scans");
    std::longjmp(managerOf(codec).escape, 1);
}

/// CMYK to RGBA in place: each ink takes its share of the light. Files with Adobe's marker hold 255 minus the ink.
void inksToRgba(std::span<uint8_t> row, bool inverted)
{
    for (size_t i = 0; i < row.size(); i += 4) {
        const auto passed = [&](size_t ink) { return uint32_t(inverted ? row[i + ink] : 255 - row[i + ink]); };
        const uint32_t black = passed(3);
        for (size_t c = 0; c < 3; ++c)
            row[i + c] = uint8_t((passed(c) * black + 127) / 255);
        row[i + 3] = 255;
    }
}

/// The part between setjmp and longjmp: no object with a destructor may live here.
bool decompress(jpeg_decompress_struct& codec, ErrorManager& manager, std::span<const uint8_t> encoded,
                const CheckSize& check, std::vector<uint8_t>& rgba)
{
    if (setjmp(manager.escape))
        return false;
    jpeg_create_decompress(&codec);
    codec.progress = &manager.progress;
    jpeg_mem_src(&codec, encoded.data(), static_cast<unsigned long>(encoded.size()));
    jpeg_read_header(&codec, TRUE);
    check(codec.image_width, codec.image_height, false);
    // libjpeg turns YCCK into CMYK, but no ink into light: that is done row by row.
    const bool inks = codec.jpeg_color_space == JCS_CMYK || codec.jpeg_color_space == JCS_YCCK;
    codec.out_color_space = inks ? JCS_CMYK : JCS_EXT_RGBA;
    jpeg_start_decompress(&codec);
    rgba.resize(size_t(codec.output_width) * codec.output_height * 4);
    while (codec.output_scanline < codec.output_height) {
        JSAMPROW row = rgba.data() + size_t(codec.output_scanline) * codec.output_width * 4;
        jpeg_read_scanlines(&codec, &row, 1);
        if (inks)
            inksToRgba({row, size_t(codec.output_width) * 4}, codec.saw_Adobe_marker);
    }
    jpeg_finish_decompress(&codec);
    return true;
}

}  // namespace

bool hasTooManyScans(uint64_t scans, uint32_t width, uint32_t height)
{
    return scans > USUAL_SCANS && scans * width * height > MAX_SCANNED_PIXELS;
}

JpegImage decodeJpeg(std::span<const uint8_t> encoded, const CheckSize& check)
{
    JpegImage image;
    jpeg_decompress_struct codec{};
    const std::unique_ptr<jpeg_decompress_struct, void (*)(j_decompress_ptr)> owner(&codec, jpeg_destroy_decompress);
    ErrorManager manager{};
    codec.err = jpeg_std_error(&manager.base);
    manager.base.error_exit = escapeWithMessage;
    manager.base.emit_message = keepWarning;
    manager.progress.progress_monitor = limitScans;
    image.valid = decompress(codec, manager, encoded, check, image.rgba);
    image.width = codec.image_width;
    image.height = codec.image_height;
    image.message = manager.message;
    return image;
}

}  // namespace restirpg::gltf
