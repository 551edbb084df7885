// Reading OpenEXR files, through the OpenEXR library: which of a file's channels are the picture, and where it lies in
// the display window.
#include "image/exr_header.h"
#include "image/limits.h"
#include "image/stored.h"

#include "core/log.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <ImfInputPart.h>
#include <ImfMultiPartInputFile.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfRgbaYca.h>
#include <ImfStandardAttributes.h>
#include <ImfStringAttribute.h>

#include <algorithm>
#include <array>
#include <functional>
#include <optional>
#include <set>

namespace restirpg {
namespace {

namespace fs = std::filesystem;
using Imath::Box2i;

enum class Kind {
    rgb,
    luminanceChroma,  ///< Y, RY, BY of OpenEXR's "luminance/chroma images"
    vector,  ///< X, Y
    luminance,  ///< Y
};

/// Where a picture lies in a file.
struct Choice {
    int part = 0;
    Kind kind = Kind::rgb;
    std::string prefix;  ///< "layer." or empty
    std::vector<std::string> names;  ///< of the channels
};

/// The first of `names` that is a channel with that prefix; empty: none.
std::string findName(const Imf::ChannelList& channels, const std::string& prefix,
                     std::initializer_list<const char*> names)
{
    for (const char* name : names)
        if (channels.findChannel(prefix + name))
            return prefix + name;
    return "";
}

/// The channels of a kind, all or none.
std::vector<std::string> findChannels(const Imf::ChannelList& channels, const std::string& prefix, Kind kind)
{
    const auto find = [&](std::initializer_list<const char*> names) { return findName(channels, prefix, names); };
    std::vector<std::string> names;
    switch (kind) {
    case Kind::rgb:
        names = {find({"R", "r", "red", "Red"}), find({"G", "g", "green", "Green"}), find({"B", "b", "blue", "Blue"})};
        break;
    case Kind::luminanceChroma:
        names = {find({"Y"}), find({"RY"}), find({"BY"})};
        break;
    case Kind::vector:
        names = {find({"X"}), find({"Y"})};
        break;
    case Kind::luminance:
        names = {find({"Y", "y"})};
        break;
    }
    return std::count(names.begin(), names.end(), "") ? std::vector<std::string>() : names;
}

class Chooser {
public:
    Chooser(const fs::path& file, const Imf::MultiPartInputFile& input) : file_(file), input_(input) {}

    Choice choose(const std::string& layer)
    {
        if (const auto choice = find(layer.empty() ? "" : layer + ".", ""))
            return *choice;
        if (const auto choice = layer.empty() ? onlyLayer() : find("", layer))
            return *choice;
        refuse(layer.empty() ? "" : layer + ".");
    }

private:
    bool deep(int part) const
    {
        const auto& header = input_.header(part);
        return header.hasType() && Imf::isDeepData(header.type());
    }

    /// The first part with a picture of the best kind; `name`: only of the part of that name.
    std::optional<Choice> find(const std::string& prefix, const std::string& name) const
    {
        for (const Kind kind : {Kind::rgb, Kind::luminanceChroma, Kind::vector, Kind::luminance})
            for (int part = 0; part < input_.parts(); ++part) {
                const auto& header = input_.header(part);
                if (deep(part) || (!name.empty() && (!header.hasName() || header.name() != name)))
                    continue;
                auto names = findChannels(header.channels(), prefix, kind);
                if (!names.empty())
                    return Choice{part, kind, prefix, std::move(names)};
            }
        return {};
    }

    /// Without plain channels: the layer that Blender calls Combined, or the only one with colours.
    std::optional<Choice> onlyLayer() const
    {
        std::vector<Choice> coloured;
        for (int part = 0; part < input_.parts(); ++part) {
            std::set<std::string> prefixes;
            const auto& channels = input_.header(part).channels();
            for (auto channel = channels.begin(); channel != channels.end(); ++channel) {
                const std::string name = channel.name();
                if (const auto dot = name.rfind('.'); dot != name.npos)
                    prefixes.insert(name.substr(0, dot + 1));
            }
            for (const auto& prefix : prefixes)
                for (const Kind kind : {Kind::rgb, Kind::luminanceChroma})
                    if (auto names = findChannels(channels, prefix, kind); !deep(part) && !names.empty())
                        coloured.push_back({part, kind, prefix, std::move(names)});
        }
        const auto combined = std::find_if(coloured.begin(), coloured.end(), [](const Choice& choice) {
            return choice.prefix == "Combined." || choice.prefix.ends_with(".Combined.");
        });
        if (combined != coloured.end())
            return *combined;
        return coloured.size() == 1 ? std::optional(coloured.front()) : std::nullopt;
    }

    [[noreturn]] void refuse(const std::string& prefix) const
    {
        std::string present;
        bool flat = false;
        for (int part = 0; part < input_.parts(); ++part) {
            flat = flat || !deep(part);
            const auto& channels = input_.header(part).channels();
            for (auto channel = channels.begin(); channel != channels.end(); ++channel)
                present += (present.empty() ? "" : ", ") + std::string(channel.name());
        }
        constexpr size_t LONGEST = 300;
        if (present.size() > LONGEST)
            present = present.substr(0, LONGEST) + "...";
        if (!flat)
            fail("{}: cannot read: deep images are not supported; flatten it to a scanline image", file_.string());
        fail("{}: cannot read: no channels {}R, {}G, {}B and no {}Y; it has {}", file_.string(), prefix, prefix, prefix,
             prefix, present);
    }

    const fs::path& file_;
    const Imf::MultiPartInputFile& input_;
};

/// Reads row `y` into `row`, which has the data window's width and three floats per pixel.
using ReadRow = std::function<void(int y)>;

/// The display window's picture from rows of the data window: what lies outside of the data window is black.
Image placeRows(const fs::path& file, const Imf::Header& header, const std::vector<float>& row, const ReadRow& read)
{
    const Box2i &data = header.dataWindow(), &display = header.displayWindow();
    const int64_t width = int64_t(display.max.x) - display.min.x + 1;
    const int64_t height = int64_t(display.max.y) - display.min.y + 1;
    checkImageClaim(file.string(), width, height, fs::file_size(file), BYTES_PER_PIXEL_FLOAT);
    Image image{uint32_t(width), uint32_t(height), 3, {}};
    image.data.resize(size_t(width) * size_t(height) * 3);
    const int left = std::max(data.min.x, display.min.x), right = std::min(data.max.x, display.max.x);
    const int top = std::max(data.min.y, display.min.y), bottom = std::min(data.max.y, display.max.y);
    if (left > display.min.x || right < display.max.x || top > display.min.y || bottom < display.max.y)
        warn("{}: its pixels cover only a part of its display window; the rest is black", file.string());
    for (int64_t y = top; y <= bottom && left <= right; ++y) {
        read(int(y));
        const float* from = row.data() + 3 * (int64_t(left) - data.min.x);
        std::copy_n(from, 3 * (int64_t(right) - left + 1),
                    &image.at(uint32_t(int64_t(left) - display.min.x), uint32_t(y - display.min.y), 0));
    }
    return image;
}

class Reader {
public:
    Reader(const fs::path& file, const Imf::MultiPartInputFile& input, const Choice& choice)
        : file_(file), choice_(choice), header_(input.header(choice.part)),
          row_(3 * (int64_t(header_.dataWindow().max.x) - header_.dataWindow().min.x + 1))
    {
    }

    Image read(Imf::MultiPartInputFile& input)
    {
        if (choice_.kind == Kind::luminanceChroma && sampling(1) == 2 && sampling(2) == 2)
            return readChroma();
        for (size_t i = 0; i < choice_.names.size(); ++i)
            if (sampling(i) != 1)
                fail("{}: cannot read: channel {} is subsampled; write it with a value for each pixel", file_.string(),
                     choice_.names[i]);
        return readFloats(input);
    }

private:
    /// 1 or 2 in both directions; 0: another one.
    int sampling(size_t channel) const
    {
        const auto& c = header_.channels()[choice_.names[channel]];
        return c.xSampling == c.ySampling && c.xSampling <= 2 ? c.xSampling : 0;
    }

    Image readFloats(Imf::MultiPartInputFile& input)
    {
        Imf::InputPart part(input, choice_.part);
        const int left = header_.dataWindow().min.x;
        Imf::FrameBuffer pixels;
        for (size_t c = 0; c < choice_.names.size(); ++c)
            // A stride of 0 from row to row: they all go into row_.
            pixels.insert(choice_.names[c],
                          Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(row_.data() + c - 3 * int64_t(left)),
                                     3 * sizeof(float), 0));
        part.setFrameBuffer(pixels);
        return placeRows(file_, header_, row_, [&](int y) {
            part.readPixels(y, y);
            complete();
        });
    }

    /// The channels that the file has to three colours.
    void complete()
    {
        Imath::V3f yw(0);
        if (choice_.kind == Kind::luminanceChroma)
            yw = Imf::RgbaYca::computeYw(chromaticitiesOf(header_));
        for (size_t i = 0; i < row_.size(); i += 3) {
            float* pixel = row_.data() + i;
            if (choice_.kind == Kind::luminance)
                pixel[1] = pixel[2] = pixel[0];
            if (choice_.kind == Kind::luminanceChroma) {
                const float luminance = pixel[0];
                const float red = (pixel[1] + 1) * luminance, blue = (pixel[2] + 1) * luminance;
                pixel[0] = red;
                pixel[1] = (luminance - red * yw.x - blue * yw.z) / yw.y;
                pixel[2] = blue;
            }
        }
    }

    /// Chroma of half the resolution, which the library interpolates.
    Image readChroma()
    {
        if (choice_.part != 0)
            fail("{}: cannot read: its part {} holds luminance and subsampled chroma; write it as R, G, B",
                 file_.string(), choice_.part);
        const auto layer = choice_.prefix.empty() ? "" : choice_.prefix.substr(0, choice_.prefix.size() - 1);
        Imf::RgbaInputFile input(file_.c_str(), layer);
        std::vector<Imf::Rgba> pixels(row_.size() / 3);
        input.setFrameBuffer(pixels.data() - int64_t(header_.dataWindow().min.x), 1, 0);
        return placeRows(file_, header_, row_, [&](int y) {
            input.readPixels(y, y);
            for (size_t x = 0; x < pixels.size(); ++x) {
                row_[3 * x] = pixels[x].r;
                row_[3 * x + 1] = pixels[x].g;
                row_[3 * x + 2] = pixels[x].b;
            }
        });
    }

    static Imf::Chromaticities chromaticitiesOf(const Imf::Header& header)
    {
        return Imf::hasChromaticities(header) ? Imf::chromaticities(header) : Imf::Chromaticities();
    }

    const fs::path& file_;
    const Choice& choice_;
    const Imf::Header& header_;
    std::vector<float> row_;
};

/// The library's exceptions as one Error. A hostile file may throw anything derived from std::exception, bad_alloc too.
template <typename Read>
auto readSafely(const fs::path& file, Read&& read)
{
    checkExrHeader(file);
    try {
        return read();
    } catch (const Error&) {
        throw;
    } catch (const std::exception& error) {
        // Its first line: an Error is one line.
        const std::string text = error.what();
        fail("{}: cannot read: {}; the file is damaged or of an unsupported kind, write it again as a scanline EXR",
             file.string(), text.substr(0, text.find('\n')));
    }
}

}  // namespace

StoredImage readStoredExr(const fs::path& file, const std::string& layer)
{
    return readSafely(file, [&] {
        Imf::MultiPartInputFile input(file.c_str());
        const Choice choice = Chooser(file, input).choose(layer);
        const Imf::Header& header = input.header(choice.part);
        StoredImage stored{Reader(file, input, choice).read(input), choice.kind != Kind::vector, {}, {}};
        if (Imf::hasChromaticities(header))
            stored.chromaticities = Imf::chromaticities(header);
        stored.neutral = Imf::hasAdoptedNeutral(header) ? Imf::adoptedNeutral(header) : stored.chromaticities.white;
        return stored;
    });
}

Image readExr(const fs::path& file, const std::string& layer)
{
    return converted(file, readStoredExr(file, layer));
}

std::map<std::string, std::string> readExrAttributes(const fs::path& file)
{
    return readSafely(file, [&] {
        Imf::InputFile input(file.c_str());
        std::map<std::string, std::string> attributes;
        for (auto entry = input.header().begin(); entry != input.header().end(); ++entry)
            if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&entry.attribute()))
                attributes[entry.name()] = text->value();
        return attributes;
    });
}

}  // namespace restirpg
