// PNG through libpng, which decodes row by row: stb_image inflates whatever a file's data claims before it looks at the
// image's size.
#include "scene/gltf_file.h"

#include <csetjmp>
#include <cstring>

#include <png.h>

namespace restirpg::gltf {

namespace {

/// Chunks that glTF says to ignore (colour spaces) or that say nothing about pixels. Some are compressed.
constexpr png_byte IGNORED_CHUNKS[] = "cHRM\0gAMA\0iCCP\0sRGB\0sBIT\0bKGD\0hIST\0pHYs\0sPLT\0tEXt\0zTXt\0iTXt\0tIME\0"
                                      "eXIf\0oFFs\0pCAL\0sCAL";

/// What libpng's callbacks see.
struct PngSource {
    std::span<const uint8_t> bytes;
    size_t position = 0;
    char message[200] = {};
};

void keepError(png_structp png, png_const_charp message)
{
    auto& source = *static_cast<PngSource*>(png_get_error_ptr(png));
    std::strncpy(source.message, message, sizeof source.message - 1);
    png_longjmp(png, 1);
}

void ignoreWarning(png_structp, png_const_charp) {}

void readSource(png_structp png, png_bytep bytes, size_t size)
{
    auto& source = *static_cast<PngSource*>(png_get_io_ptr(png));
    if (size > source.bytes.size() - source.position)
        png_error(png, "the data ends too early");
    std::memcpy(bytes, source.bytes.data() + source.position, size);
    source.position += size;
}

/// Owns libpng's structures.
struct Decoder {
    explicit Decoder(PngSource& source)
        : png(png_create_read_struct(PNG_LIBPNG_VER_STRING, &source, keepError, ignoreWarning)),
          info(png_create_info_struct(png))
    {
        png_set_read_fn(png, &source, readSource);
        // The caller's limits are stricter.
        png_set_user_limits(png, PNG_UINT_31_MAX, PNG_UINT_31_MAX);
        png_set_keep_unknown_chunks(png, PNG_HANDLE_CHUNK_NEVER, IGNORED_CHUNKS, int(sizeof IGNORED_CHUNKS / 5));
    }
    ~Decoder() { png_destroy_read_struct(&png, &info, nullptr); }
    Decoder(const Decoder&) = delete;
    Decoder& operator=(const Decoder&) = delete;

    png_structp png;
    png_infop info;
};

/// The part between setjmp and longjmp: no object with a destructor may live here.
bool decompress(Decoder& decoder, const CheckSize& check, PngImage& image)
{
    png_structp png = decoder.png;
    if (setjmp(png_jmpbuf(png)))
        return false;
    png_read_info(png, decoder.info);
    image.width = png_get_image_width(png, decoder.info);
    image.height = png_get_image_height(png, decoder.info);
    image.sixteenBits = png_get_bit_depth(png, decoder.info) == 16;
    check(image.width, image.height, image.sixteenBits);

    png_set_expand(png);
    png_set_gray_to_rgb(png);
    png_set_add_alpha(png, 0xffff, PNG_FILLER_AFTER);
    png_set_swap(png);
    const int passes = png_set_interlace_handling(png);
    png_read_update_info(png, decoder.info);
    const size_t row = png_get_rowbytes(png, decoder.info);
    image.rgba.resize(row * image.height);
    for (int pass = 0; pass < passes; ++pass)
        for (uint32_t y = 0; y < image.height; ++y)
            png_read_row(png, image.rgba.data() + y * row, nullptr);
    png_read_end(png, nullptr);
    return true;
}

}  // namespace

PngImage decodePng(std::span<const uint8_t> encoded, const CheckSize& check)
{
    PngImage image;
    PngSource source{encoded};
    Decoder decoder(source);
    image.valid = decompress(decoder, check, image);
    image.message = source.message;
    return image;
}

}  // namespace restirpg::gltf
