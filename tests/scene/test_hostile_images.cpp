// Damaged and hostile images: always one clear line, never a crash.
#include "../support/sample_texture.h"
#include "hostile.h"

#include "core/log.h"
#include "scene/gltf.h"
#include "scene/gltf_file.h"

#include <zlib.h>

#include <algorithm>
#include <random>

using namespace restirpg;

namespace {

void append32(std::vector<uint8_t>& bytes, uint32_t value)
{
    for (int shift = 24; shift >= 0; shift -= 8)
        bytes.push_back(uint8_t(value >> shift));
}

void appendChunk(std::vector<uint8_t>& png, const std::string& type, const std::vector<uint8_t>& data)
{
    append32(png, uint32_t(data.size()));
    const size_t begin = png.size();
    png.insert(png.end(), type.begin(), type.end());
    png.insert(png.end(), data.begin(), data.end());
    append32(png, uint32_t(crc32(0, png.data() + begin, uInt(png.size() - begin))));
}

/// A grey PNG with a header of this size and `raw` bytes of zeros as its compressed data.
std::vector<uint8_t> forgedPng(uint32_t width, uint32_t height, uint8_t depth, size_t raw)
{
    std::vector<uint8_t> png = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'}, header;
    append32(header, width);
    append32(header, height);
    header.insert(header.end(), {depth, 0, 0, 0, 0});
    appendChunk(png, "IHDR", header);
    const std::vector<uint8_t> zeros(raw);
    std::vector<uint8_t> data(compressBound(uLong(raw)));
    uLongf size = uLongf(data.size());
    compress(data.data(), &size, zeros.data(), uLong(raw));
    data.resize(size);
    appendChunk(png, "IDAT", data);
    appendChunk(png, "IEND", {});
    return png;
}

GltfBuilder sceneWithImage(const std::vector<uint8_t>& encoded)
{
    auto builder = squareScene();
    const int texture = builder.addTexture(encoded);
    builder.addMaterial({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
    primitiveOf(builder)["material"] = 0;
    return builder;
}

long peakKibibytes()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    return usage.ru_maxrss;
}

}  // namespace

TEST(HostileImages, ImagesThatDoNotDecodeAreNamed)
{
    const auto textured = [](const std::vector<uint8_t>& image) {
        return [=](GltfBuilder& b) {
            primitiveOf(b)["material"] = b.addMaterial({{"normalTexture", {{"index", b.addTexture(image)}}}});
            b.json["images"][0]["name"] = "Bricks";
        };
    };
    auto png = encodePng(4, 4, std::vector<uint8_t>(64, 9));
    auto truncated = png;
    truncated.resize(45);
    expectError(textured(truncated), {"image 0 'Bricks'", "damaged"});
    expectError(textured(std::vector<uint8_t>(40, 1)), {"image 0 'Bricks'", "not a PNG or JPEG"});
    expectError(textured(forgedPng(8323076, 4, 8, 64)), {"image 0 'Bricks'", "8323076 x 4"});
    expectError(textured(forgedPng(0, 4, 8, 64)), {"image 0 'Bricks'", "damaged"});
    expectError(textured(forgedPng(4, 4, 8, 7)), {"image 0 'Bricks'", "damaged"});
    auto flipped = png;
    flipped[19] ^= 1;
    expectError(textured(flipped), {"image 0 'Bricks'", "damaged (IHDR: CRC error)"});
    expectError(
        [&](auto& b) {
            textured(png)(b);
            b.json["textures"][0].erase("source");
        },
        {"textures[0]", "no PNG or JPEG"});
}

TEST(HostileImages, ForgedJpegsAreErrorsOrDamagedPictures)
{
    const auto jpeg = encodeJpeg(16, 16, std::vector<uint8_t>(1024, 77));
    const auto loadWith = [](const std::vector<uint8_t>& image) {
        auto builder = squareScene();
        primitiveOf(builder)["material"] =
            builder.addMaterial({{"normalTexture", {{"index", builder.addTexture(image)}}}});
        return load(builder);
    };
    EXPECT_NEAR(sampleTexture(loadWith(jpeg).textures[0], {0.5f, 0.5f}).x, 77.0f / 255, 0.01f);
    // 255 codes of every length: more than the table holds.
    auto forged = jpeg;
    const std::vector<uint8_t> marker = {0xff, 0xc4};
    const auto table = std::search(forged.begin(), forged.end(), marker.begin(), marker.end());
    ASSERT_NE(table, forged.end());
    std::fill(table + 5, table + 21, 255);
    EXPECT_NE(errorOf([&] { loadWith(forged); }).find("Bogus"), std::string::npos);
    std::vector<uint8_t> noise(1024);
    std::generate(noise.begin(), noise.end(), std::mt19937(5));
    auto truncated = encodeJpeg(16, 16, noise);
    truncated.resize(truncated.size() - 20);
    EXPECT_EQ(loadWith(truncated).textures[0].width, 16u);
    const auto said = saidWarnings();
    EXPECT_TRUE(std::any_of(said.begin(), said.end(),
                            [](const auto& text) { return text.find("image 0: is damaged") != text.npos; }));
}

/// Encoders write some 10 scans, whatever the size; a scan of a bomb has a few bytes.
TEST(HostileImages, JpegsMayHaveTheScansOfEncodersAtAnySize)
{
    using gltf::hasTooManyScans;
    EXPECT_FALSE(hasTooManyScans(10, 16384, 16384));
    EXPECT_FALSE(hasTooManyScans(2048, 1024, 1024));
    EXPECT_TRUE(hasTooManyScans(17, 16384, 16384));
    EXPECT_TRUE(hasTooManyScans(2049, 1024, 1024));
}

TEST(HostileImages, ABombIsRefusedByItsHeader)
{
    const long before = peakKibibytes();
    for (const uint8_t depth : {1, 8, 16}) {
        const auto message = errorOf(sceneWithImage(forgedPng(16384, 16384, depth, 1 << 20)));
        EXPECT_NE(message.find("image 0: cannot read: the header claims 16384x16384 pixels"), message.npos) << message;
        EXPECT_NE(message.find("decompression bomb"), message.npos) << message;
    }
    EXPECT_LT(peakKibibytes() - before, 32 << 10);
}

TEST(HostileImages, DataBeyondTheHeadersSizeIsNotInflated)
{
    const auto builder = sceneWithImage(forgedPng(4, 4, 8, 256 << 20));
    const long before = peakKibibytes();
    EXPECT_EQ(load(builder).textures.at(0).width, 4u);
    EXPECT_LT(peakKibibytes() - before, 32 << 10);
}

TEST_F(HostileInLittleMemory, AnImageThatNeedsMoreThanThereIsIsOneLine)
{
    const auto builder = sceneWithImage(forgedPng(8000, 8000, 16, 8 << 20));
    limitTo(3);
    const auto message = errorOf(builder);
    EXPECT_NE(message.find("image 0: cannot read: an image of 8000x8000 pixels needs 3.3 GiB of memory, of which 1."),
              message.npos)
        << message;
}

/// Not damaged, and large for a machine of 16 GB: 8192 x 4096.
TEST(HostileImages, AnImageOfEightThousandPixelsIsRead)
{
    EXPECT_EQ(load(sceneWithImage(forgedPng(8192, 4096, 8, 8193u << 12))).textures.at(0).bytes.size(), 4u << 25);
}
