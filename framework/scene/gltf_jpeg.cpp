// JPEG through libjpeg-turbo. (stb_image's decoder writes past its Huffman tables on forged files.)
#include "scene/gltf_file.h"

#include <csetjmp>
#include <cstdio>

#include <jpeglib.h>

namespace restirpg::gltf {

namespace {

/// libjpeg reports a fatal error by a callback that must not return.
struct ErrorManager {
    jpeg_error_mgr base;
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

/// The part between setjmp and longjmp: no object with a destructor may live here.
bool decompress(jpeg_decompress_struct& codec, ErrorManager& manager, std::span<const uint8_t> encoded,
                uint32_t largestSide, std::vector<uint8_t>& rgba)
{
    if (setjmp(manager.escape))
        return false;
    jpeg_create_decompress(&codec);
    jpeg_mem_src(&codec, encoded.data(), static_cast<unsigned long>(encoded.size()));
    jpeg_read_header(&codec, TRUE);
    if (codec.image_width > largestSide || codec.image_height > largestSide)
        return true;
    codec.out_color_space = JCS_EXT_RGBA;
    jpeg_start_decompress(&codec);
    rgba.resize(size_t(codec.output_width) * codec.output_height * 4);
    while (codec.output_scanline < codec.output_height) {
        JSAMPROW row = rgba.data() + size_t(codec.output_scanline) * codec.output_width * 4;
        jpeg_read_scanlines(&codec, &row, 1);
    }
    jpeg_finish_decompress(&codec);
    return true;
}

}  // namespace

JpegImage decodeJpeg(std::span<const uint8_t> encoded, uint32_t largestSide)
{
    JpegImage image;
    jpeg_decompress_struct codec{};
    ErrorManager manager{};
    codec.err = jpeg_std_error(&manager.base);
    manager.base.error_exit = escapeWithMessage;
    manager.base.emit_message = keepWarning;
    image.valid = decompress(codec, manager, encoded, largestSide, image.rgba);
    image.width = codec.image_width;
    image.height = codec.image_height;
    image.message = manager.message;
    jpeg_destroy_decompress(&codec);
    return image;
}

}  // namespace restirpg::gltf
