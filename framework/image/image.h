// Float images in memory, their files, and the display transform.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace restirpg {

/// Interleaved float image, rows from the top. pixel (x, y), channel c at data[(y * width + x) * channels + c].
struct Image {
    uint32_t width = 0;
    uint32_t height = 0;
    uint32_t channels = 0;
    std::vector<float> data;

    bool empty() const { return data.empty(); }
    float& at(uint32_t x, uint32_t y, uint32_t c) { return data[(size_t(y) * width + x) * channels + c]; }
    float at(uint32_t x, uint32_t y, uint32_t c) const { return data[(size_t(y) * width + x) * channels + c]; }
};

/// One named image of a multi-layer EXR. The layer with the empty name has the plain channels R, G, B.
struct Layer {
    std::string name;
    Image image;
};

enum class PixelType { half, full };

/// Write layers (all of one size) and string attributes as one scanline EXR (ZIP), to a temporary name in the same
/// folder and then renamed. Channel names: R, G, B for 3 channels, Y for 1, X, Y for 2, R, G, B, A for 4; `NAME.`
/// before them for a named layer. Values are linear and unclamped; half floats saturate at 65504, with a warning.
/// Throws Error naming the file when it cannot be written, a layer is empty or the sizes differ.
void writeExr(const std::filesystem::path& file, const std::vector<Layer>& layers, PixelType type,
              const std::map<std::string, std::string>& attributes = {});

/// Read the picture of an EXR's display window as 3 channels of linear Rec.709; what its data window leaves out is
/// black. The picture is, of the first part that has it: R, G, B (upper or lower case), else Y, RY, BY, else X, Y and
/// 0, else Y three times; without a `layer` and plain channels: the layer Combined or the only one with colours.
/// `layer` may be a part's name. Half, float and unsigned integers are read as the numbers they are; attributes
/// `chromaticities` and `adoptedNeutral` say what their colours are. Deep images, subsampled R, G, B, damaged,
/// truncated or absurdly large files are one Error.
Image readExr(const std::filesystem::path& file, const std::string& layer = "");

/// String attributes of an EXR header.
std::map<std::string, std::string> readExrAttributes(const std::filesystem::path& file);

/// Read a Radiance .hdr (RGBE or XYZE, run-length coded or not, of any orientation) as 3 channels of linear Rec.709, in
/// the units before EXPOSURE and COLORCORR. Damaged or truncated files are one Error.
Image readHdr(const std::filesystem::path& file);

/// Read an .exr or .hdr as radiance: infinite values saturate, NaN and negative ones become 0, each with a warning.
Image readRadiance(const std::filesystem::path& file);

/// Scene-linear Rec.709 to display, through OpenColorIO's CPU processor.
struct DisplayTransform {
    std::string config;  ///< path of a .ocio file; empty: the project's own small config
    std::string display;  ///< empty: the config's default
    std::string view;  ///< empty: the config's default
    float exposure = 0;  ///< stops
};

/// Throws Error when the config, display or view is not there (naming the choices): to be asked before a long
/// rendering.
void checkDisplay(const DisplayTransform& transform);

/// An 8-bit PNG file's bytes of a 3-channel (or 1-channel) image. Pixels with a NaN or an infinity become black. Throws
/// Error, of `place`, when the config, display or view is not there (naming the choices).
std::string encodePng(const Image& image, const DisplayTransform& transform, const std::string& place);

/// Write such a file, atomically. Throws Error when it cannot be written too.
void writePng(const std::filesystem::path& file, const Image& image, const DisplayTransform& transform = {});

}  // namespace restirpg
