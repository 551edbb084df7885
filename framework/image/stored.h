// Pictures as their files store them, before colours are converted and infinities mended.
#pragma once

#include "image/image.h"

#include <ImathVec.h>
#include <ImfChromaticities.h>

namespace restirpg {

struct StoredImage {
    Image image;
    bool colours = true;  ///< R, G, B; false: numbers of another meaning, such as motion
    Imf::Chromaticities chromaticities;  ///< Rec.709 where the file says nothing
    Imath::V2f neutral = Imf::Chromaticities().white;
};

StoredImage readStoredExr(const std::filesystem::path& file, const std::string& layer);
StoredImage readStoredHdr(const std::filesystem::path& file);

/// In linear Rec.709.
Image converted(const std::filesystem::path& file, StoredImage stored);

}  // namespace restirpg
