// Colour spaces of image files: all become linear Rec.709, which the renderer works in.
#pragma once

#include "image/image.h"

#include <ImathVec.h>
#include <ImfChromaticities.h>

#include <string>

namespace restirpg {

/// CIE XYZ written as primaries: the conversion from there leaves the stimulus as it is.
inline const Imf::Chromaticities CIE_XYZ{{1, 0}, {0, 1}, {0, 0}, {1.0f / 3, 1.0f / 3}};

/// Convert a picture of linear RGB with the primaries `from` to linear Rec.709 in place. `neutral` is the chromaticity
/// that the picture means by white; it becomes Rec.709's by von Kries' scaling of Bradford's cone responses, as OpenEXR
/// converts ACES files (ImfAcesFile.cpp). CIE XYZ has no white of its own and is not adapted. Colours outside Rec.709's
/// gamut have negative components then. Throws Error beginning with `place` when the chromaticities span no colours.
void toRec709(const std::string& place, Image& image, const Imf::Chromaticities& from, Imath::V2f neutral);

}  // namespace restirpg
