#include "image/exr_header.h"

#include "core/error_kinds.h"
#include "image/limits.h"

#include <ImfCompression.h>
#include <OpenEXRConfig.h>

#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <map>
#include <optional>
#include <string>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

static_assert(std::endian::native == std::endian::little, "EXR files are little endian and are read without swapping");

constexpr int32_t MAGIC = 20000630;
constexpr int32_t VERSION_MASK = 0xff;
constexpr int32_t DEEP_FLAG = 0x800;
constexpr int32_t MULTI_PART_FLAG = 0x1000;
constexpr size_t MAX_NAME = 255;

/// Attributes that the library reads without looking at their size: with a wrong one it would go on reading elsewhere
/// than here.
const std::map<std::string, int32_t> FIXED_SIZES = {{"box2i", 16},      {"box2f", 16},   {"chromaticities", 32},
                                                    {"compression", 1}, {"double", 8},   {"envmap", 1},
                                                    {"float", 4},       {"int", 4},      {"keycode", 28},
                                                    {"lineOrder", 1},   {"m33f", 36},    {"m33d", 72},
                                                    {"m44f", 64},       {"m44d", 128},   {"rational", 8},
                                                    {"tiledesc", 9},    {"timecode", 8}, {"v2i", 8},
                                                    {"v2f", 8},         {"v2d", 16},     {"v3i", 12},
                                                    {"v3f", 12},        {"v3d", 24},     {"deepImageState", 1}};

class HeaderWalker {
public:
    explicit HeaderWalker(const fs::path& file) : file_(file)
    {
        std::error_code missing;
        size_ = fs::file_size(file, missing);
        stream_.open(file, std::ios::binary);
        if (missing || !stream_)
            failToRead(file, "{}: cannot read: {}; name an existing EXR file", file.string(),
                       missing ? missing.message() : std::strerror(errno));
    }

    void walk()
    {
        if (size_ < 8 || read<int32_t>() != MAGIC)
            fail("{}: cannot read: not an OpenEXR file; name a file that begins with EXR's magic number",
                 file_.string());
        const int32_t version = read<int32_t>();
        if ((version & VERSION_MASK) != 2)
            damaged("its version is not 2");
        if ((version & DEEP_FLAG) && !(version & MULTI_PART_FLAG))
            fail("{}: cannot read: deep images are not supported; flatten it to a scanline image", file_.string());
        walkPart();
        // The headers of a multi-part file end with an empty one, i.e. a zero byte.
        while ((version & MULTI_PART_FLAG) && stream_.peek() > 0)
            walkPart();
    }

private:
    [[noreturn]] void damaged(const std::string& what)
    {
        fail("{}: cannot read: {}; the file is damaged or truncated, write it again", file_.string(), what);
    }

    template <typename T>
    T read()
    {
        T value{};
        if (!stream_.read(reinterpret_cast<char*>(&value), sizeof value))
            damaged("it ends inside its header");
        return value;
    }

    /// Zero-terminated; empty at the end of a header.
    std::string readName()
    {
        std::string name;
        for (char c = read<char>(); c != 0; c = read<char>()) {
            name += c;
            if (name.size() > MAX_NAME)
                damaged("an attribute's name has more than 255 characters");
        }
        return name;
    }

    void walkPart()
    {
        std::optional<std::array<int64_t, 2>> window, tile;
        for (std::string name = readName(); !name.empty(); name = readName()) {
            const std::string type = readName();
            const int32_t size = read<int32_t>();
            const std::streamoff begin = stream_.tellg();
            if (size < 0 || uint64_t(size) > size_ - uint64_t(begin))
                damaged(fmt::format("an attribute claims {} bytes", size));
            checkSize(type, size);
            if (name == "dataWindow" && size == 16) {
                const auto box = read<std::array<int32_t, 4>>();  // left, top, right, bottom, all inclusive
                window = {int64_t(box[2]) - box[0] + 1, int64_t(box[3]) - box[1] + 1};
                checkImageClaim(file_.string(), (*window)[0], (*window)[1], size_, BYTES_PER_PIXEL_FLOAT);
            } else if (name == "tiles" && size == 9) {
                const auto sides = read<std::array<uint32_t, 2>>();
                tile = {sides[0], sides[1]};
                checkImageClaim(file_.string(), sides[0], sides[1], size_, BYTES_PER_PIXEL_FLOAT);
            } else if (name == "chunkCount" && size == 4) {
                checkChunks(read<int32_t>());
            } else if (name == "compression" && size == 1) {
                const int method = read<uint8_t>();
                if (method >= Imf::NUM_COMPRESSION_METHODS)
                    fail("{}: cannot read: compression method {} is not known to OpenEXR {}; write it with another one",
                         file_.string(), method, OPENEXR_VERSION_STRING);
            }
            stream_.seekg(begin + size);
        }
        if (!window)
            damaged("its header has no data window");
        if (tile)
            checkChunks(((*window)[0] + (*tile)[0] - 1) / (*tile)[0] * (((*window)[1] + (*tile)[1] - 1) / (*tile)[1]));
    }

    void checkSize(const std::string& type, int32_t size)
    {
        const std::streamoff begin = stream_.tellg();
        int64_t expected = size;
        if (const auto fixed = FIXED_SIZES.find(type); fixed != FIXED_SIZES.end()) {
            expected = fixed->second;
        } else if (type == "chlist") {
            constexpr int CHANNEL = 16;  // bytes after the name
            while (!readName().empty())
                stream_.seekg(CHANNEL, std::ios::cur);
            expected = stream_.tellg() - begin;
        } else if (type == "preview") {
            const auto sides = read<std::array<uint32_t, 2>>();
            expected =
                sides[0] <= MAX_IMAGE_SIDE && sides[1] <= MAX_IMAGE_SIDE ? 8 + 4 * int64_t(sides[0]) * sides[1] : -1;
        }
        if (expected != size)
            damaged(fmt::format("an attribute of type {} claims {} bytes", type.substr(0, 32), size));
        stream_.seekg(begin);
    }

    /// Every chunk of pixels has an offset of 8 bytes in a table.
    void checkChunks(int64_t count)
    {
        if (count < 0 || uint64_t(count) > size_ / 8)
            damaged(fmt::format("it claims {} blocks of pixels", count));
    }

    fs::path file_;
    uint64_t size_ = 0;
    std::ifstream stream_;
};

}  // namespace

void checkExrHeader(const fs::path& file)
{
    HeaderWalker(file).walk();
}

}  // namespace restirpg
