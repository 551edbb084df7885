// Error metrics of an image against a reference, in double precision.
#pragma once

#include "image/image.h"

namespace restirpg {

/// What two linear, unclamped images of one size and 3 channels differ by. Y = 0.2126 R + 0.7152 G + 0.0722 B
/// (Rec.709).
struct Errors {
    /// Mean over pixels and channels of |I - R| / (0.01 mean(Y_R) + Y_R).  [Zeng et al. 2025, footnote 4]
    double mape;
    double relMse;  ///< mean over pixels and channels of (I - R)^2 / (R^2 + 0.01)
    double rmse;  ///< sqrt of the mean squared difference
    double bias;  ///< signed: (mean(I) - mean(R)) / mean(R), over pixels and channels
    uint64_t invalid;  ///< pixels with a NaN or an infinity in either image; left out of all the means
};

/// Throws Error when the sizes differ or there are not 3 channels. Without a valid pixel the figures are NaN; an error
/// relative to an all-black reference is infinite.
Errors measureErrors(const Image& image, const Image& reference);

}  // namespace restirpg
