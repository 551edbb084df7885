// The display transform, through OpenColorIO, and PNG files, through libpng.
#include "image/image.h"

#include "core/error_kinds.h"
#include "core/log.h"
#include "core/output_file.h"
#include "core/paths.h"

#include <OpenColorIO/OpenColorIO.h>
#include <png.h>

#include <algorithm>
#include <cmath>
#include <functional>

namespace restirpg {
namespace {

namespace fs = std::filesystem;
namespace ocio = OCIO_NAMESPACE;

std::string join(int count, const std::function<const char*(int)>& name)
{
    std::string text;
    for (int i = 0; i < count; ++i)
        text += (i ? ", " : "") + std::string(name(i));
    return text;
}

/// Where the renderer's linear Rec.709 lies in a config. In ACES configs the role scene_linear has other primaries, so
/// the names that such configs use for linear Rec.709 come first.
std::string sourceSpace(const ocio::Config& config, const std::string& file)
{
    for (const char* name :
         {"lin_rec709", "Linear Rec.709 (sRGB)", "lin_rec709_srgb", "Utility - Linear - sRGB", "lin_srgb"})
        if (config.getColorSpace(name))
            return name;
    warn("{}: no colour space named lin_rec709 or alike; its role scene_linear is taken to be linear Rec.709", file);
    return ocio::ROLE_SCENE_LINEAR;
}

/// The view of `display` to use: the config's default, or `wanted` after a check.
std::string chooseView(const ocio::Config& config, const std::string& file, const std::string& display,
                       const std::string& wanted)
{
    const int count = config.getNumViews(display.c_str());
    const auto name = [&](int i) { return config.getView(display.c_str(), i); };
    if (count == 0)
        failAs<WrongValue>("{}: it has no display '{}'; choose from {}", file, display,
                           join(config.getNumDisplays(), [&](int i) { return config.getDisplay(i); }));
    if (wanted.empty())
        return config.getDefaultView(display.c_str());
    for (int i = 0; i < count; ++i)
        if (wanted == name(i))
            return wanted;
    failAs<WrongValue>("{}: display '{}' has no view '{}'; choose from {}", file, display, wanted, join(count, name));
}

ocio::ConstCPUProcessorRcPtr makeProcessor(const DisplayTransform& transform)
{
    const std::string file = transform.config.empty() ? displayConfig().string() : transform.config;
    try {
        const ocio::ConstConfigRcPtr config = ocio::Config::CreateFromFile(file.c_str());
        const std::string display = transform.display.empty() ? config->getDefaultDisplay() : transform.display;
        const auto view = ocio::DisplayViewTransform::Create();
        view->setSrc(sourceSpace(*config, file).c_str());
        view->setDisplay(display.c_str());
        view->setView(chooseView(*config, file, display, transform.view).c_str());
        return config->getProcessor(view)->getDefaultCPUProcessor();
    } catch (const ocio::Exception& error) {
        std::string text = error.what();
        std::replace(text.begin(), text.end(), '\n', ' ');
        fail("{}: cannot use it as an OpenColorIO config: {}", file, text);
    }
}

/// Three channels, exposed, with black where a value is not finite.
std::vector<float> exposed(const std::string& place, const Image& image, float stops)
{
    if (image.empty() || (image.channels != 1 && image.channels != 3))
        failAs<WrongValue>("{}: cannot write: a PNG is made of 1 or 3 channels, the image is {}x{}x{}", place,
                           image.width, image.height, image.channels);
    const float gain = std::exp2(stops);
    const size_t pixels = size_t(image.width) * image.height;
    std::vector<float> rgb(3 * pixels);
    for (size_t p = 0; p < pixels; ++p) {
        const float* in = image.data.data() + p * image.channels;
        const bool valid = std::all_of(in, in + image.channels, [&](float v) { return std::isfinite(v * gain); });
        for (uint32_t c = 0; c < 3; ++c)
            rgb[3 * p + c] = valid ? in[image.channels == 3 ? c : 0] * gain : 0.0f;
    }
    return rgb;
}

std::string encode(const std::string& place, uint32_t width, uint32_t height, const std::vector<uint8_t>& rgb)
{
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = width;
    png.height = height;
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string encoded(size, 0);
    if (!png_image_write_to_memory(&png, encoded.data(), &size, 0, rgb.data(), 0, nullptr))
        fail("{}: cannot write: {}", place, png.message);
    encoded.resize(size);
    return encoded;
}

}  // namespace

void checkDisplay(const DisplayTransform& transform)
{
    makeProcessor(transform);
}

std::string encodePng(const Image& image, const DisplayTransform& transform, const std::string& place)
{
    std::vector<float> rgb = exposed(place, image, transform.exposure);
    ocio::PackedImageDesc pixels(rgb.data(), long(image.width), long(image.height), 3);
    makeProcessor(transform)->apply(pixels);

    std::vector<uint8_t> bytes(rgb.size());
    std::transform(rgb.begin(), rgb.end(), bytes.begin(),
                   [](float v) { return uint8_t(std::lround(255.0f * std::clamp(v, 0.0f, 1.0f))); });
    return encode(place, image.width, image.height, bytes);
}

void writePng(const fs::path& file, const Image& image, const DisplayTransform& transform)
{
    writeFile(file, encodePng(image, transform, file.string()));
}

}  // namespace restirpg
