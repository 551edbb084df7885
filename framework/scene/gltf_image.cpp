// PNG and JPEG through stb_image, compiled here with nothing but those two decoders.
#include "scene/gltf_file.h"
#include "scene/srgb.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <span>

#define STB_IMAGE_IMPLEMENTATION
#define STB_IMAGE_STATIC
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_NO_STDIO
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace restirpg::gltf {

namespace {

/// What every Vulkan device in use samples (maxImageDimension2D); also keeps a forged header from asking for terabytes.
constexpr int LARGEST_SIDE = 16384;

std::span<const uint8_t> encodedBytes(const File& file, const tinygltf::Image& image)
{
    if (image.bufferView < 0)
        return image.image;
    const auto& view = file.model.bufferViews[size_t(image.bufferView)];
    return {file.model.buffers[size_t(view.buffer)].data.data() + view.byteOffset, view.byteLength};
}

}  // namespace

void decodeImage(const File& file, int index, Texture& texture)
{
    const auto& image = file.model.images[size_t(index)];
    const auto place = label("image", size_t(index), image.name.empty() ? image.uri : image.name);
    const auto encoded = encodedBytes(file, image);
    if (encoded.empty())
        fail("{}: {}: cannot be read; put the file beside the scene", file.name(), place);

    const int length = int(encoded.size());
    int width = 0, height = 0, channels = 0;
    if (!stbi_info_from_memory(encoded.data(), length, &width, &height, &channels))
        fail("{}: {}: is not a PNG or JPEG; save the image again", file.name(), place);
    if (width < 1 || height < 1 || width > LARGEST_SIDE || height > LARGEST_SIDE)
        fail("{}: {}: is {} x {} pixels; scale it to at most {} a side", file.name(), place, width, height, LARGEST_SIDE);

    const auto decoded = [&](auto* pixels) {
        if (!pixels)
            fail("{}: {}: is damaged ({}); save the image again", file.name(), place, stbi_failure_reason());
        return std::unique_ptr<std::remove_pointer_t<decltype(pixels)>, decltype(&stbi_image_free)>(pixels, stbi_image_free);
    };
    const size_t count = size_t(width) * size_t(height) * 4;
    if (stbi_is_16_bit_from_memory(encoded.data(), length)) {
        const auto pixels = decoded(stbi_load_16_from_memory(encoded.data(), length, &width, &height, &channels, 4));
        texture.floats.resize(count);
        for (size_t i = 0; i < count; ++i) {
            const float value = float(pixels.get()[i]) / 65535.0f;
            texture.floats[i] = texture.srgb && i % 4 != 3 ? srgbToLinear(value) : value;
        }
    } else {
        const auto pixels = decoded(stbi_load_from_memory(encoded.data(), length, &width, &height, &channels, 4));
        texture.bytes.assign(pixels.get(), pixels.get() + count);
    }
    texture.width = uint32_t(width);
    texture.height = uint32_t(height);
}

}  // namespace restirpg::gltf
