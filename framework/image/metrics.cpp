#include "image/metrics.h"

#include "core/error_kinds.h"

#include <cmath>
#include <limits>

namespace restirpg {
namespace {

double luminance(const float* rgb)
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

bool isFinite(const float* rgb)
{
    return std::isfinite(rgb[0]) && std::isfinite(rgb[1]) && std::isfinite(rgb[2]);
}

/// A term that is exact zero stays zero, whatever it is relative to: equal black images have no error.
double relative(double difference, double scale)
{
    return difference == 0.0 ? 0.0 : difference / scale;
}

}  // namespace

Errors measureErrors(const Image& image, const Image& reference)
{
    if (image.channels != 3 || reference.channels != 3)
        failAs<WrongValue>("cannot compare images of {} and {} channels; both need 3", image.channels,
                           reference.channels);
    if (image.width != reference.width || image.height != reference.height)
        failAs<WrongValue>("cannot compare a {}x{} image with a {}x{} reference; render at the reference's size",
                           image.width, image.height, reference.width, reference.height);

    const size_t pixels = size_t(image.width) * image.height;
    uint64_t valid = 0;
    double meanLuminance = 0.0;
    for (size_t p = 0; p < pixels; ++p)
        if (isFinite(&image.data[3 * p]) && isFinite(&reference.data[3 * p])) {
            ++valid;
            meanLuminance += luminance(&reference.data[3 * p]);
        }
    if (valid == 0) {
        const double none = std::numeric_limits<double>::quiet_NaN();
        return {none, none, none, none, pixels};
    }
    meanLuminance /= double(valid);

    double absolute = 0.0, relativeSquared = 0.0, squared = 0.0, difference = 0.0, total = 0.0;
    for (size_t p = 0; p < pixels; ++p) {
        const float* i = &image.data[3 * p];
        const float* r = &reference.data[3 * p];
        if (!isFinite(i) || !isFinite(r))
            continue;
        const double scale = 0.01 * meanLuminance + luminance(r);
        for (int c = 0; c < 3; ++c) {
            const double d = double(i[c]) - double(r[c]);
            absolute += relative(std::abs(d), scale);
            relativeSquared += d * d / (double(r[c]) * r[c] + 0.01);
            squared += d * d;
            difference += d;
            total += r[c];
        }
    }
    const double count = 3.0 * double(valid);
    return {absolute / count, relativeSquared / count, std::sqrt(squared / count), relative(difference, total),
            pixels - valid};
}

}  // namespace restirpg
