// A look at an EXR header before the library reads it.
#pragma once

#include <filesystem>

namespace restirpg {

/// Walk the header of every part of an EXR file and throw Error when the file is missing, no EXR, deep, cut short, or
/// when an attribute, a data window, a tile or a count of blocks claims more than the file can hold. OpenEXR 3.1
/// allocates by those claims unchecked. Layout: "OpenEXR File Layout",
/// https://openexr.com/en/latest/OpenEXRFileLayout.html.
void checkExrHeader(const std::filesystem::path& file);

}  // namespace restirpg
