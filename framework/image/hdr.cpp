// Radiance .hdr (RGBE, XYZE). Own code, since stb_image's reader loops for ever on a truncated file, and both it and
// OpenImageIO's leave out the exposure.  [G. Ward Larson, Radiance File Formats, "Picture"]
#include "core/error_kinds.h"
#include "image/colour.h"
#include "image/limits.h"
#include "image/stored.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

using Rgbe = std::array<uint8_t, 4>;

/// Bytes of a file, taken in order; running out of them is an Error.
class ByteReader {
public:
    explicit ByteReader(const fs::path& file) : file_(file)
    {
        std::error_code ignored;
        std::ifstream stream;
        if (fs::is_regular_file(file, ignored))  // a pipe or a device may have no end
            stream.open(file, std::ios::binary);
        if (!stream.is_open())
            failToRead(file, "{}: cannot read the file; name an existing Radiance .hdr file", file.string());
        checkMemory(file.string() + ": cannot read", "the file", fs::file_size(file), "scale the image down");
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
        for (char c = char(next()); c != '\n'; c = char(next()))  // or CR LF, as some programs write
            line += c;
        if (line.ends_with('\r'))
            line.pop_back();
        return line;
    }

private:
    fs::path file_;
    std::vector<char> bytes_;
    size_t position_ = 0;
};

/// Mantissas are 8 bits below a shared exponent with a bias of 128.  [G. Ward, Real Pixels, Graphics Gems II]
void decode(const Rgbe& pixel, const std::array<double, 3>& factor, float* rgb)
{
    const float scale = pixel[3] == 0 ? 0.0f : std::ldexp(1.0f, int(pixel[3]) - (128 + 8));
    for (size_t c = 0; c < 3; ++c)
        rgb[c] = float(pixel[c] * scale / factor[c]);
}

struct Header {
    bool xyz = false;
    /// What all pixels were multiplied with: the product of all EXPOSURE and COLORCORR lines.
    std::array<double, 3> factor = {1, 1, 1};
    std::optional<Imf::Chromaticities> primaries;
    /// A scanline runs along X (or Y); the first pixel of the file lies at the end of an axis where it is reversed.
    bool rowsAlongX = true;
    bool reversedX = false;
    bool reversedY = false;
    uint32_t width = 0;
    uint32_t height = 0;

    uint32_t scanlines() const { return rowsAlongX ? height : width; }
    uint32_t length() const { return rowsAlongX ? width : height; }
};

/// `count` numbers, separated by white space. Their point is one in any locale, unlike std::strtod's.
template <size_t count>
std::array<double, count> numbers(const fs::path& file, const std::string& key, const std::string& text)
{
    std::array<double, count> values{};
    const char* begin = text.data();
    const char* const end = begin + text.size();
    for (double& value : values) {
        begin = std::find_if(begin, end, [](char c) { return c != ' ' && c != '\t'; });
        if (begin != end && *begin == '+')
            ++begin;
        const auto read = std::from_chars(begin, end, value);
        if (read.ec != std::errc() || !std::isfinite(value))
            fail("{}: cannot read: {} is not followed by {} number{}; mend the header", file.string(), key, count,
                 count == 1 ? "" : "s");
        begin = read.ptr;
    }
    return values;
}

void multiply(const fs::path& file, const std::string& key, std::array<double, 3>& factor,
              const std::array<double, 3>& by)
{
    for (size_t c = 0; c < 3; ++c) {
        factor[c] *= by[c];
        if (!(factor[c] > 0) || !std::isfinite(factor[c]))
            fail("{}: cannot read: {} is not a positive number; mend the header", file.string(), key);
    }
}

/// A line KEY=VALUE; others are comments and the history of commands.
void readLine(const fs::path& file, const std::string& line, Header& header)
{
    const auto equals = line.find('=');
    if (equals == line.npos)
        return;
    const std::string key = line.substr(0, equals);
    const std::string value = line.substr(std::min(line.find_first_not_of(" \t", equals + 1), line.size()));
    if (key == "FORMAT") {
        header.xyz = value == "32-bit_rle_xyze";
        if (!header.xyz && value != "32-bit_rle_rgbe")
            fail("{}: cannot read: FORMAT={} is not supported; write it as 32-bit_rle_rgbe", file.string(),
                 value.substr(0, 40));
    } else if (key == "EXPOSURE") {
        const double exposure = numbers<1>(file, key, value)[0];
        multiply(file, key, header.factor, {exposure, exposure, exposure});
    } else if (key == "COLORCORR") {
        multiply(file, key, header.factor, numbers<3>(file, key, value));
    } else if (key == "PRIMARIES") {
        const auto v = numbers<8>(file, key, value);
        const auto xy = [&](size_t i) { return Imath::V2f(float(v[2 * i]), float(v[2 * i + 1])); };
        header.primaries = Imf::Chromaticities(xy(0), xy(1), xy(2), xy(3));
    }
}

/// "-Y HEIGHT +X WIDTH": two axes, the one from scanline to scanline first; -Y is from the top, +X from the left.
void readResolution(const fs::path& file, const std::string& line, Header& header)
{
    std::array<char, 2> signs{}, axes{};
    std::array<int, 2> sizes{};
    const int found =
        std::sscanf(line.c_str(), "%c%c %9d %c%c %9d", &signs[0], &axes[0], &sizes[0], &signs[1], &axes[1], &sizes[1]);
    const auto isSign = [](char c) { return c == '+' || c == '-'; };
    const bool axesGiven = (axes[0] == 'X' && axes[1] == 'Y') || (axes[0] == 'Y' && axes[1] == 'X');
    if (found != 6 || !axesGiven || !isSign(signs[0]) || !isSign(signs[1]))
        fail("{}: cannot read: the resolution line is not of the form '-Y HEIGHT +X WIDTH'; mend the header",
             file.string());
    const size_t x = axes[0] == 'X' ? 0 : 1, y = 1 - x;
    header.rowsAlongX = x == 1;
    header.reversedX = signs[x] == '-';
    header.reversedY = signs[y] == '+';
    header.width = uint32_t(std::max(sizes[x], 0));
    header.height = uint32_t(std::max(sizes[y], 0));
}

/// The header up to and with the resolution line.
Header readHeader(const fs::path& file, ByteReader& reader)
{
    Header header;
    const std::string magic = reader.nextLine();
    if (magic.rfind("#?", 0) != 0)
        fail("{}: cannot read: not a Radiance .hdr file (it does not begin with #?)", file.string());
    for (std::string line = reader.nextLine(); !line.empty(); line = reader.nextLine())
        readLine(file, line, header);
    readResolution(file, reader.nextLine(), header);
    checkImageClaim(file.string(), header.width, header.height, reader.size(), BYTES_PER_PIXEL_FLOAT);
    return header;
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

void readScanline(const fs::path& file, ByteReader& reader, std::vector<Rgbe>& row)
{
    const Rgbe first = reader.nextPixel();
    const size_t length = row.size();
    if (first[0] == 2 && first[1] == 2 && size_t(first[2] << 8 | first[3]) == length && length >= 8 && length < 32768)
        readCodedRow(file, reader, row);
    else
        readPlainRow(file, reader, row, first);
}

}  // namespace

StoredImage readStoredHdr(const fs::path& file)
{
    ByteReader reader(file);
    const Header header = readHeader(file, reader);
    StoredImage stored{{header.width, header.height, 3, {}}, true, {}, {}};
    stored.image.data.resize(size_t(header.width) * header.height * 3);
    std::vector<Rgbe> scanline(header.length());
    for (uint32_t i = 0; i < header.scanlines(); ++i) {
        readScanline(file, reader, scanline);
        for (uint32_t j = 0; j < header.length(); ++j) {
            const uint32_t x = header.rowsAlongX ? j : i, y = header.rowsAlongX ? i : j;
            float* pixel = &stored.image.at(header.reversedX ? header.width - 1 - x : x,
                                            header.reversedY ? header.height - 1 - y : y, 0);
            decode(scanline[j], header.factor, pixel);
        }
    }
    if (header.xyz)
        stored.chromaticities = CIE_XYZ;
    else if (header.primaries)
        stored.chromaticities = *header.primaries;
    stored.neutral = stored.chromaticities.white;
    return stored;
}

Image readHdr(const fs::path& file)
{
    return converted(file, readStoredHdr(file));
}

}  // namespace restirpg
