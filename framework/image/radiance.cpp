// Pictures as radiance: finite, at least 0, linear Rec.709.
#include "image/colour.h"
#include "image/stored.h"

#include "core/error.h"
#include "core/log.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

constexpr float LARGEST_HALF = 65504;

/// An infinity is a value that did not fit when the file was written: mostly a sun in half floats. It becomes the
/// largest half float, or the largest value of the picture where that is larger. Before the conversion of colours,
/// which would spread it over the other channels.
void saturate(const fs::path& file, Image& image)
{
    float largest = LARGEST_HALF;
    for (const float value : image.data)
        if (std::isfinite(value))
            largest = std::max(largest, value);
    size_t infinite = 0, nan = 0;
    for (float& value : image.data) {
        infinite += std::isinf(value);
        nan += std::isnan(value);
        value = std::isnan(value) ? 0.0f : std::clamp(value, -largest, largest);
    }
    if (infinite)
        warn("{}: {} infinite values are read as {:g}; write full floats to keep what they were", file.string(),
             infinite, largest);
    if (nan)
        warn("{}: {} values that are not numbers (NaN) are read as 0", file.string(), nan);
}

void clampNegative(const fs::path& file, Image& image)
{
    size_t negative = 0;
    for (float& value : image.data) {
        negative += value < 0;
        value = std::clamp(value, 0.0f, std::numeric_limits<float>::max());
    }
    if (negative)
        warn("{}: {} negative values are read as 0", file.string(), negative);
}

}  // namespace

Image converted(const fs::path& file, StoredImage stored)
{
    if (stored.colours)
        toRec709(file.string(), stored.image, stored.chromaticities, stored.neutral);
    return std::move(stored.image);
}

Image readRadiance(const fs::path& file)
{
    std::string extension = file.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    StoredImage stored = extension == ".hdr" ? readStoredHdr(file) : readStoredExr(file, "");
    if (!stored.colours)
        fail("{}: cannot read: it has channels X and Y but no colours; give an image with R, G and B", file.string());
    saturate(file, stored.image);
    Image image = converted(file, std::move(stored));
    clampNegative(file, image);
    return image;
}

}  // namespace restirpg
