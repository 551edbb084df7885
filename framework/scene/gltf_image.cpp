// Images of the file to textures: what a header claims is checked before it is decoded.
#include "image/limits.h"
#include "scene/gltf_file.h"
#include "scene/srgb.h"

#include <cstring>

namespace restirpg::gltf {

namespace {

/// What every Vulkan device in use samples (maxImageDimension2D); also keeps a forged header from asking for terabytes.
constexpr uint32_t LARGEST_SIDE = 16384;

std::span<const uint8_t> encodedBytes(const File& file, const tinygltf::Image& image)
{
    if (image.bufferView < 0)
        return image.image;
    const auto& view = file.model.bufferViews[size_t(image.bufferView)];
    return {file.model.buffers[size_t(view.buffer)].data.data() + view.byteOffset, view.byteLength};
}

/// The check of a header of an encoded image of so many bytes.
CheckSize sizeCheck(const File& file, const std::string& place, size_t bytes)
{
    return [=, name = file.name() + ": " + place](uint32_t width, uint32_t height, bool sixteenBits) {
        if (width > LARGEST_SIDE || height > LARGEST_SIDE)
            fail("{}: is {} x {} pixels; scale it to at most {} a side", name, width, height, LARGEST_SIDE);
        checkImageClaim(name, width, height, bytes, sixteenBits ? BYTES_PER_PIXEL_16 : BYTES_PER_PIXEL_8);
    };
}

/// 16-bit values to floats between 0 and 1; colours are decoded where the texture is sRGB.
std::vector<float> toFloats(const std::vector<uint8_t>& words, bool srgb)
{
    std::vector<float> linear(65536), decoded(65536);
    for (size_t i = 0; i < linear.size(); ++i) {
        linear[i] = float(i) / 65535.0f;
        decoded[i] = srgb ? srgbToLinear(linear[i]) : linear[i];
    }
    std::vector<float> floats(words.size() / 2);
    for (size_t i = 0; i < floats.size(); ++i) {
        uint16_t word;
        std::memcpy(&word, words.data() + 2 * i, sizeof word);
        floats[i] = (i % 4 == 3 ? linear : decoded)[word];
    }
    return floats;
}

void decodePngInto(const File& file, const std::string& place, std::span<const uint8_t> encoded, Texture& texture)
{
    auto image = decodePng(encoded, sizeCheck(file, place, encoded.size()));
    if (!image.valid)
        fail("{}: {}: is damaged ({}); save the image again", file.name(), place, printable(image.message));
    if (image.sixteenBits)
        texture.floats = toFloats(image.rgba, texture.srgb);
    else
        texture.bytes = std::move(image.rgba);
    texture.width = image.width;
    texture.height = image.height;
}

void decodeJpegInto(const File& file, const std::string& place, std::span<const uint8_t> encoded, Texture& texture)
{
    auto image = decodeJpeg(encoded, sizeCheck(file, place, encoded.size()));
    if (!image.valid)
        fail("{}: {}: is damaged ({}); save the image again", file.name(), place, printable(image.message));
    if (!image.message.empty())
        warn("{}: {}: is damaged ({})", file.name(), place, printable(image.message));
    texture.bytes = std::move(image.rgba);
    texture.width = image.width;
    texture.height = image.height;
}

/// The bytes that every file of a format has at one place.
bool hasMagic(std::span<const uint8_t> encoded, std::string_view magic, size_t offset = 0)
{
    return encoded.size() >= offset + magic.size() &&
           std::memcmp(encoded.data() + offset, magic.data(), magic.size()) == 0;
}

/// The name of a format that this reader lacks.
const char* formatOf(std::span<const uint8_t> encoded)
{
    struct Format {
        const char* name;
        std::string_view magic;
        size_t offset;
    };
    static constexpr Format FORMATS[] = {{"WebP", "WEBP", 8},       {"KTX2", "KTX 20", 1},     {"AVIF", "ftypavif", 4},
                                         {"HEIF", "ftyphei", 4},    {"GIF", "GIF8", 0},        {"BMP", "BM", 0},
                                         {"TIFF", "II*", 0},        {"TIFF", "MM", 0},         {"DDS", "DDS ", 0},
                                         {"OpenEXR", "v/1\x01", 0}, {"Radiance HDR", "#?", 0}, {"JPEG XL", "JXL ", 4},
                                         {"JPEG 2000", "jP  ", 4}};
    for (const auto& format : FORMATS)
        if (hasMagic(encoded, format.magic, format.offset))
            return format.name;
    return "damaged or of an unknown format";
}

}  // namespace

void decodeImage(const File& file, int index, Texture& texture)
{
    const auto& image = file.model.images[size_t(index)];
    const auto place = label("image", size_t(index), image.name.empty() ? image.uri : image.name);
    const auto encoded = encodedBytes(file, image);
    if (encoded.empty() && !image.uri.empty())
        file.resources.resolveExisting(image.uri, fmt::format("images[{}]", index));
    if (encoded.empty())
        fail("{}: {}: cannot be read; put the file beside the scene", file.name(), place);
    if (hasMagic(encoded, "\xff\xd8"))
        decodeJpegInto(file, place, encoded, texture);
    else if (hasMagic(encoded, "\x89PNG\r\n\x1a\n"))
        decodePngInto(file, place, encoded, texture);
    else
        fail("{}: {}: is {}, not a PNG or JPEG; save the image as one of them", file.name(), place, formatOf(encoded));
}

}  // namespace restirpg::gltf
