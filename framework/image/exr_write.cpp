// Writing OpenEXR files, through the OpenEXR library.
#include "image/image.h"

#include "core/error.h"
#include "core/log.h"
#include "core/output_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfIO.h>
#include <ImfOutputFile.h>
#include <ImfStringAttribute.h>
#include <half.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

/// The first line of a library's message: an Error is one line.
std::string firstLine(const std::string& text)
{
    return text.substr(0, text.find('\n'));
}

std::vector<std::string> channelNames(const fs::path& file, const Layer& layer)
{
    static const std::array<std::vector<std::string>, 5> suffixes = {
        {{}, {"Y"}, {"X", "Y"}, {"R", "G", "B"}, {"R", "G", "B", "A"}}};
    const Image& image = layer.image;
    if (image.channels < 1 || image.channels > 4)
        fail("{}: cannot write: layer '{}' has {} channels; 1 to 4 can be written", file.string(), layer.name,
             image.channels);
    if (image.empty() || image.data.size() != size_t(image.width) * image.height * image.channels)
        fail("{}: cannot write: layer '{}' has {} values, not {}x{}x{}", file.string(), layer.name, image.data.size(),
             image.width, image.height, image.channels);
    std::vector<std::string> names = suffixes[image.channels];
    for (std::string& name : names)
        name = layer.name.empty() ? name : layer.name + "." + name;
    return names;
}

/// Finite values beyond half's range become its largest: an infinity would be read back as an invalid pixel.
std::vector<half> toHalf(const fs::path& file, const std::vector<float>& values)
{
    size_t saturated = 0;
    std::vector<half> result(values.size());
    std::transform(values.begin(), values.end(), result.begin(), [&](float value) {
        if (!std::isfinite(value) || std::abs(value) <= HALF_MAX)
            return half(value);
        ++saturated;
        return half(std::copysign(float(HALF_MAX), value));
    });
    if (saturated > 0)
        warn("{}: {} values beyond +-65504 do not fit half floats and were written as +-65504; write full floats to "
             "keep them",
             file.string(), saturated);
    return result;
}

/// The library's view of an OutputFile. It swallows what fails in its destructors; `commit` does not.
class ExrStream final : public Imf::OStream {
public:
    ExrStream(const fs::path& file, OutputFile& output) : OStream(file.c_str()), output_(output) {}

    void write(const char bytes[], int size) override { output_.write(bytes, size_t(size)); }
    uint64_t tellp() override { return output_.position(); }
    void seekp(uint64_t position) override { output_.seek(position); }

private:
    OutputFile& output_;
};

/// The library refuses names of the header's own attributes, which are no text.
void insertAttributes(const fs::path& file, const std::map<std::string, std::string>& attributes, Imf::Header& header)
{
    for (const auto& [name, value] : attributes) {
        try {
            header.insert(name, Imf::StringAttribute(value));
        } catch (const std::exception& error) {
            fail("{}: cannot write: attribute '{}': {}; choose another name for it", file.string(), name,
                 firstLine(error.what()));
        }
    }
}

void storePixels(const fs::path& file, const Imf::Header& header, const Imf::FrameBuffer& pixels)
{
    OutputFile output(file);
    try {
        ExrStream stream(file, output);
        Imf::OutputFile exr(stream, header);
        exr.setFrameBuffer(pixels);
        exr.writePixels(header.dataWindow().max.y + 1);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        fail("{}: cannot write: {}", file.string(), firstLine(error.what()));
    }
    output.commit();
}

}  // namespace

void writeExr(const fs::path& file, const std::vector<Layer>& layers, PixelType type,
              const std::map<std::string, std::string>& attributes)
{
    if (layers.empty())
        fail("{}: cannot write: no layers; give at least one image", file.string());
    const uint32_t width = layers.front().image.width;
    const uint32_t height = layers.front().image.height;
    const Imf::PixelType stored = type == PixelType::half ? Imf::HALF : Imf::FLOAT;

    Imf::Header header{int(width), int(height)};
    header.compression() = Imf::ZIP_COMPRESSION;
    insertAttributes(file, attributes, header);

    std::vector<std::vector<half>> halves(layers.size());
    Imf::FrameBuffer pixels;
    for (size_t l = 0; l < layers.size(); ++l) {
        const Image& image = layers[l].image;
        const std::vector<std::string> names = channelNames(file, layers[l]);
        if (image.width != width || image.height != height)
            fail("{}: cannot write: layer '{}' is {}x{} and the first layer {}x{}; layers must be of one size",
                 file.string(), layers[l].name, image.width, image.height, width, height);
        const size_t size = type == PixelType::half ? sizeof(half) : sizeof(float);
        const char* data = reinterpret_cast<const char*>(image.data.data());
        if (type == PixelType::half) {
            halves[l] = toHalf(file, image.data);
            data = reinterpret_cast<const char*>(halves[l].data());
        }
        for (uint32_t c = 0; c < image.channels; ++c) {
            header.channels().insert(names[c], Imf::Channel(stored));
            // The library takes a pointer to mutable data for writing too.
            pixels.insert(names[c], Imf::Slice(stored, const_cast<char*>(data) + c * size, size * image.channels,
                                               size * image.channels * width));
        }
    }
    storePixels(file, header, pixels);
}

}  // namespace restirpg
