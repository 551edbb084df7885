// Radiance .hdr (RGBE). Own code, since stb_image's reader loops for ever on a truncated file and ignores the
// orientation.
#include "image/image.h"
#include "image/limits.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

using Rgbe = std::array<uint8_t, 4>;

/// Bytes of a file, taken in order; running out of them is an Error.
class ByteReader {
public:
    explicit ByteReader(const fs::path& file) : file_(file)
    {
        std::ifstream stream(file, std::ios::binary);
        if (!stream || fs::is_directory(file))
            fail("{}: cannot read the file; name an existing Radiance .hdr file", file.string());
        bytes_.assign(std::istreambuf_iterator<char>(stream), {});
    }

    uint64_t size() const { return bytes_.size(); }

    uint8_t next()
    {
        if (position_ == bytes_.size())
            fail("{}: cannot read: the file ends before its last row; it is truncated, write it again", file_.string());
        return uint8_t(bytes_[position_++]);
    }

    Rgbe nextPixel() { return {next(), next(), next(), next()}; }

    std::string nextLine()
    {
        std::string line;
        for (char c = char(next()); c != '\n'; c = char(next()))
            line += c;
        return line;
    }

private:
    fs::path file_;
    std::vector<char> bytes_;
    size_t position_ = 0;
};

/// Mantissas are 8 bits below a shared exponent with a bias of 128.  [G. Ward, Real Pixels, Graphics Gems II]
void decode(const Rgbe& pixel, float* rgb)
{
    const float scale = pixel[3] == 0 ? 0.0f : std::ldexp(1.0f, int(pixel[3]) - (128 + 8));
    for (int c = 0; c < 3; ++c)
        rgb[c] = pixel[c] * scale;
}

/// The header up to and with the resolution line; returns width and height.
std::array<int, 2> readHeader(const fs::path& file, ByteReader& reader)
{
    const std::string magic = reader.nextLine();
    if (magic.rfind("#?", 0) != 0)
        fail("{}: cannot read: not a Radiance .hdr file (it does not begin with #?)", file.string());
    for (std::string line = reader.nextLine(); !line.empty(); line = reader.nextLine())
        if (line.rfind("FORMAT=", 0) == 0 && line != "FORMAT=32-bit_rle_rgbe")
            fail("{}: cannot read: {} is not supported; write it as 32-bit_rle_rgbe", file.string(),
                 line.substr(0, 40));
    int width = 0, height = 0;
    const std::string resolution = reader.nextLine();
    if (std::sscanf(resolution.c_str(), "-Y %9d +X %9d", &height, &width) != 2)
        fail("{}: cannot read: the resolution line is not '-Y HEIGHT +X WIDTH'; write it with rows from the top",
             file.string());
    checkImageClaim(file, width, height, reader.size());
    return {width, height};
}

/// A row with its four components run-length coded one after the other; `first` is its marker, already read.
void readCodedRow(const fs::path& file, ByteReader& reader, std::vector<Rgbe>& row)
{
    for (int component = 0; component < 4; ++component)
        for (size_t x = 0; x < row.size();) {
            const uint8_t code = reader.next();
            const size_t count = code > 128 ? code - 128 : code;
            if (count == 0 || count > row.size() - x)
                fail("{}: cannot read: a run leaves its row; the file is damaged, write it again", file.string());
            const uint8_t run = code > 128 ? reader.next() : 0;
            for (const size_t end = x + count; x < end; ++x)
                row[x][component] = code > 128 ? run : reader.next();
        }
}

/// A row of plain pixels, of which the first is already read. A pixel (1, 1, 1, n) repeats the one before it n times;
/// when several follow each other, n counts 256 times more at each.
void readPlainRow(const fs::path& file, ByteReader& reader, std::vector<Rgbe>& row, Rgbe pixel)
{
    uint32_t shift = 0;
    for (size_t x = 0; x < row.size();) {
        if (pixel[0] == 1 && pixel[1] == 1 && pixel[2] == 1) {
            const size_t count = shift <= 24 ? size_t(pixel[3]) << shift : row.size();
            if (x == 0 || count > row.size() - x)
                fail("{}: cannot read: a run leaves its row; the file is damaged, write it again", file.string());
            const Rgbe before = row[x - 1];
            std::fill_n(row.begin() + ptrdiff_t(x), count, before);
            x += count;
            shift += 8;
        } else {
            row[x++] = pixel;
            shift = 0;
        }
        if (x < row.size())
            pixel = reader.nextPixel();
    }
}

}  // namespace

Image readHdr(const fs::path& file)
{
    ByteReader reader(file);
    const auto [width, height] = readHeader(file, reader);
    Image image{uint32_t(width), uint32_t(height), 3, {}};
    image.data.resize(size_t(width) * height * 3);
    std::vector<Rgbe> row(width);
    for (int y = 0; y < height; ++y) {
        const Rgbe first = reader.nextPixel();
        if (first[0] == 2 && first[1] == 2 && (first[2] << 8 | first[3]) == width && width >= 8 && width < 32768)
            readCodedRow(file, reader, row);
        else
            readPlainRow(file, reader, row, first);
        for (int x = 0; x < width; ++x)
            decode(row[x], &image.at(uint32_t(x), uint32_t(y), 0));
    }
    return image;
}

}  // namespace restirpg
