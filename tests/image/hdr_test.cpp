// Radiance files: each kind of row, with pixels decoded by hand.
#include "fixture.h"

// Static, since libtinygltf exports functions of the same names.
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb/stb_image_write.h>

namespace restirpg {
namespace {

/// (128, 64, 32) * 2^(129 - 136).
const std::string PIXEL("\x80\x40\x20\x81", 4);

class Hdr : public FolderTest {
protected:
    Image readWhole(const std::string& text)
    {
        writeBytes(folder_ / "a.hdr", {text.begin(), text.end()});
        return readHdr(folder_ / "a.hdr");
    }

    /// Six pixels whose red is 1 to 6 in the file's order.
    std::vector<float> reds(const std::string& resolution)
    {
        std::string pixels;
        for (char red = 1; red <= 6; ++red)
            pixels += std::string{red, 0, 0, char(136)};
        std::vector<float> values;
        const Image image = readWhole("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n" + resolution + "\n" + pixels);
        for (size_t i = 0; i < image.data.size(); i += 3)
            values.push_back(image.data[i]);
        return values;
    }

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

TEST_F(Hdr, ExposureAndColourCorrectionAreTakenBackHoweverOftenTheyWereApplied)
{
    const Image image = readWhole("#?RADIANCE\nEXPOSURE=2\nEXPOSURE= 0.25\n\tEXPOSURE=1000\nCOLORCORR=1 2 4\n"
                                  "FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n" +
                                  PIXEL);
    EXPECT_EQ(image.data, (std::vector<float>{2.0f, 0.5f, 0.125f}));
}

TEST_F(Hdr, LinesMayEndInCrLfAndTheFormatMayBeMissing)
{
    for (const char* header : {"#?RADIANCE\r\nFORMAT=32-bit_rle_rgbe\r\n\r\n-Y 1 +X 1\r\n", "#?RGBE\n\n-Y 1 +X 1\n",
                               "#?RADIANCE\nSOFTWARE=x\nFORMAT= 32-bit_rle_rgbe\n\n-Y 1 +X 1\n"})
        EXPECT_EQ(readWhole(header + PIXEL).data, (std::vector<float>{1.0f, 0.5f, 0.25f})) << header;
}

TEST_F(Hdr, AllEightOrientationsAreRead)
{
    // 3 x 2 pixels; of scanlines along X first.
    EXPECT_EQ(reds("-Y 2 +X 3"), (std::vector<float>{1, 2, 3, 4, 5, 6}));
    EXPECT_EQ(reds("-Y 2 -X 3"), (std::vector<float>{3, 2, 1, 6, 5, 4}));
    EXPECT_EQ(reds("+Y 2 +X 3"), (std::vector<float>{4, 5, 6, 1, 2, 3}));
    EXPECT_EQ(reds("+Y 2 -X 3"), (std::vector<float>{6, 5, 4, 3, 2, 1}));
    EXPECT_EQ(reds("+X 3 -Y 2"), (std::vector<float>{1, 3, 5, 2, 4, 6}));
    EXPECT_EQ(reds("-X 3 -Y 2"), (std::vector<float>{5, 3, 1, 6, 4, 2}));
    EXPECT_EQ(reds("+X 3 +Y 2"), (std::vector<float>{2, 4, 6, 1, 3, 5}));
    EXPECT_EQ(reds("-X 3 +Y 2"), (std::vector<float>{6, 4, 2, 5, 3, 1}));
}

TEST_F(Hdr, XyzAndOtherPrimariesBecomeRec709)
{
    // Rec.709's red, (0.4124, 0.2126, 0.0193), in steps of 1/512.
    const Image red =
        readWhole("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + std::string("\xd3\x6d\x0a\x7f", 4));
    EXPECT_NEAR(red.data[0], 1, 0.01);
    EXPECT_NEAR(red.data[1], 0, 0.01);
    EXPECT_NEAR(red.data[2], 0, 0.01);
    // P3's red; its white stays white.
    const std::string p3 = "#?RADIANCE\nPRIMARIES=0.68 0.32 0.265 0.69 0.15 0.06 0.3127 0.329\n\n-Y 1 +X 2\n";
    const Image image = readWhole(p3 + std::string("\x80\0\0\x81\x80\x80\x80\x81", 8));
    const std::vector<float> expected = {1.22494f, -0.04206f, -0.01964f, 1, 1, 1};
    for (size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(image.data[i], expected[i], 1e-4) << i;
}

TEST_F(Hdr, HeadersThatMakeNoSenseAreOneLine)
{
    for (const auto& [lines, message] : std::vector<std::pair<std::string, std::string>>{
             {"EXPOSURE=0\n\n-Y 1 +X 1\n", "EXPOSURE is not a positive number"},
             {"EXPOSURE=-1\n\n-Y 1 +X 1\n", "EXPOSURE is not a positive number"},
             {"EXPOSURE=nan\n\n-Y 1 +X 1\n", "EXPOSURE is not followed by 1 number;"},
             {"COLORCORR=1 2\n\n-Y 1 +X 1\n", "COLORCORR is not followed by 3 numbers"},
             {"PRIMARIES=0 0 0 0 0 0 0 0\n\n-Y 1 +X 1\n", "its chromaticities"},
             {"FORMAT=Radiance_spectra\n\n-Y 1 +X 1\n", "FORMAT=Radiance_spectra is not supported"},
             {"\n-Y 1 +Y 1\n", "the resolution line"},
             {"\n-Y -1 +X 1\n", "the image is empty (1x0)"},
             {"\n-Y 99999 +X 1\n", "the header claims 1x99999 pixels"}}) {
        const std::string text = "#?RADIANCE\n" + lines + PIXEL;
        const std::string error = errorOf([&] { readWhole(text); });
        EXPECT_TRUE(contains(error, "a.hdr: cannot read: " + message)) << error;
    }
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
    for (uint32_t i = 0; i < 3600; ++i) {
        const uint32_t step = i / 300;
        image.data.push_back(float(step) * 0.7f + 0.01f * float(i % 3));
    }
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
