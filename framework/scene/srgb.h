// The sRGB transfer function.
#pragma once

#include <cmath>

namespace restirpg {

/// Linear value of an sRGB encoded one, both in [0, 1] [IEC 61966-2-1].
inline float srgbToLinear(float encoded)
{
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

}  // namespace restirpg
