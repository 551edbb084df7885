// Radiance files: each kind of row, with pixels decoded by hand.
#include "fixture.h"

// Static, since libtinygltf exports functions of the same names.
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

namespace restirpg {
namespace {

class Hdr : public FolderTest {
protected:
    Image read(const std::string& size, const std::string& pixels)
    {
        const std::string text = "#?RADIANCE\n# a comment\nFORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + pixels;
        writeBytes(folder_ / "a.hdr", {text.begin(), text.end()});
        return readHdr(folder_ / "a.hdr");
    }
};

TEST_F(Hdr, PlainPixelsDecodeByTheSharedExponent)
{
    // 128 * 2^(129-136) = 1; 64 * 2^(130-136) = 1; exponent 0 is black.
    const Image image = read("-Y 1 +X 2", std::string("\x80\x40\x20\x81"
                                                      "\x40\x20\x10\x00",
                                                      8));
    EXPECT_EQ(image.data, (std::vector<float>{1.0f, 0.5f, 0.25f, 0.0f, 0.0f, 0.0f}));
}

TEST_F(Hdr, OldRunsRepeatThePixelBefore)
{
    // One pixel, then it again 3 times and 1 * 256 times more: 260.
    const Image image = read("-Y 1 +X 260", std::string("\x80\x40\x20\x81"
                                                        "\1\1\1\3"
                                                        "\1\1\1\1",
                                                        12));
    for (uint32_t x = 0; x < 260; ++x)
        ASSERT_EQ(image.at(x, 0, 1), 0.5f) << x;
}

TEST_F(Hdr, CodedRowsMixRunsAndLiterals)
{
    // 8 pixels: red a run of 8; green 4 literals and a run of 4; blue a run; exponent a run of 8.
    const Image image = read("-Y 1 +X 8", std::string("\2\2\0\10"
                                                      "\x88\x80"
                                                      "\4\1\2\3\4\x84\5"
                                                      "\x88\x20"
                                                      "\x88\x88",
                                                      17));
    EXPECT_EQ(image.at(0, 0, 0), 128.0f);
    EXPECT_EQ(image.at(2, 0, 1), 3.0f);
    EXPECT_EQ(image.at(7, 0, 1), 5.0f);
    EXPECT_EQ(image.at(7, 0, 2), 32.0f);
}

TEST_F(Hdr, AFileOfAnotherWriterIsReadWithinItsPrecision)
{
    Image image{40, 30, 3, {}};
    for (uint32_t i = 0; i < 3600; ++i)
        image.data.push_back(float(i / 300) * 0.7f + 0.01f * float(i % 3));
    stbi_write_hdr((folder_ / "a.hdr").c_str(), 40, 30, 3, image.data.data());
    const Image read = readHdr(folder_ / "a.hdr");
    ASSERT_EQ(read.data.size(), image.data.size());
    for (size_t p = 0; p < image.data.size(); p += 3) {
        // A mantissa has 8 bits below the largest component, of which at least 7 are used.
        const float step = std::max({image.data[p], image.data[p + 1], image.data[p + 2]}) / 128.0f;
        for (size_t c = p; c < p + 3; ++c)
            ASSERT_NEAR(read.data[c], image.data[c], step);
    }
}

TEST_F(Hdr, ATruncatedFileIsAnErrorAtEveryLength)
{
    const std::string pixels("\2\2\0\10"
                             "\x88\x80"
                             "\4\1\2\3\4\x84\5"
                             "\x88\x20"
                             "\x88\x88",
                             17);
    for (size_t size = 0; size < pixels.size(); ++size)
        EXPECT_TRUE(contains(errorOf([&] { read("-Y 1 +X 8", pixels.substr(0, size)); }), "it is truncated")) << size;
}

}  // namespace
}  // namespace restirpg
