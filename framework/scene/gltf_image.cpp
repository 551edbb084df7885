// Images of the file to textures. PNG is stb_image's, compiled here with no other decoder; JPEG is libjpeg-turbo's.
#include "scene/gltf_file.h"
#include "scene/srgb.h"

#include <memory>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

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

void checkSize(const File& file, const std::string& place, uint32_t width, uint32_t height)
{
    if (width < 1 || height < 1 || width > LARGEST_SIDE || height > LARGEST_SIDE)
        fail("{}: {}: is {} x {} pixels; scale it to at most {} a side", file.name(), place, width, height,
             LARGEST_SIDE);
}

void decodePngInto(const File& file, const std::string& place, std::span<const uint8_t> encoded, Texture& texture)
{
    const int length = int(encoded.size());
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(encoded.data(), length, &width, &height, &channels))
        fail("{}: {}: is not a PNG or JPEG; save the image again", file.name(), place);
    checkSize(file, place, uint32_t(width), uint32_t(height));

    const auto owned = [&](auto* pixels) {
        if (!pixels)
            fail("{}: {}: is damaged ({}); save the image again", file.name(), place, stbi_failure_reason());
        return std::unique_ptr<std::remove_pointer_t<decltype(pixels)>, decltype(&stbi_image_free)>(pixels,
                                                                                                    stbi_image_free);
    };
    const size_t count = size_t(width) * size_t(height) * 4;
    if (stbi_is_16_bit_from_memory(encoded.data(), length)) {
        const auto pixels = owned(stbi_load_16_from_memory(encoded.data(), length, &width, &height, &channels, 4));
        texture.floats.resize(count);
        for (size_t i = 0; i < count; ++i) {
            const float value = float(pixels.get()[i]) / 65535.0f;
            texture.floats[i] = texture.srgb && i % 4 != 3 ? srgbToLinear(value) : value;
        }
    } else {
        const auto pixels = owned(stbi_load_from_memory(encoded.data(), length, &width, &height, &channels, 4));
        texture.bytes.assign(pixels.get(), pixels.get() + count);
    }
    texture.width = uint32_t(width);
    texture.height = uint32_t(height);
}

void decodeJpegInto(const File& file, const std::string& place, std::span<const uint8_t> encoded, Texture& texture)
{
    auto image = decodeJpeg(encoded, LARGEST_SIDE);
    if (!image.valid)
        fail("{}: {}: is damaged ({}); save the image again", file.name(), place, printable(image.message));
    checkSize(file, place, image.width, image.height);
    if (!image.message.empty())
        warn("{}: {}: is damaged ({})", file.name(), place, printable(image.message));
    texture.bytes = std::move(image.rgba);
    texture.width = image.width;
    texture.height = image.height;
}

}  // namespace

void decodeImage(const File& file, int index, Texture& texture)
{
    const auto& image = file.model.images[size_t(index)];
    const auto place = label("image", size_t(index), image.name.empty() ? image.uri : image.name);
    const auto encoded = encodedBytes(file, image);
    if (encoded.empty())
        fail("{}: {}: cannot be read; put the file beside the scene", file.name(), place);
    const bool jpeg = encoded.size() > 2 && encoded[0] == 0xff && encoded[1] == 0xd8;
    jpeg ? decodeJpegInto(file, place, encoded, texture) : decodePngInto(file, place, encoded, texture);
}

}  // namespace restirpg::gltf
