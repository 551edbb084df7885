// PNG files and the display transform: known code values, choices of config, display and view, and damaged pixels.
#include "fixture.h"

#include "core/paths.h"

// Static, since libtinygltf exports functions of the same names.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#include <stb/stb_image.h>

#include <cmath>
#include <limits>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

class Png : public FolderTest {
protected:
    /// The 8-bit values of the image's PNG.
    std::vector<int> shown(const Image& image, const DisplayTransform& transform = {})
    {
        writePng(folder_ / "a.png", image, transform);
        int width = 0, height = 0, channels = 0;
        stbi_uc* bytes = stbi_load((folder_ / "a.png").c_str(), &width, &height, &channels, 3);
        EXPECT_EQ(width, int(image.width));
        EXPECT_EQ(height, int(image.height));
        std::vector<int> values(bytes, bytes + size_t(width) * size_t(height) * 3);
        stbi_image_free(bytes);
        return values;
    }

    fs::path config(const std::string& text)
    {
        writeBytes(folder_ / "own.ocio", {text.begin(), text.end()});
        return folder_ / "own.ocio";
    }
};

/// IEC 61966-2-1.
int srgbCode(double linear)
{
    const double encoded = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
    return int(std::lround(255 * encoded));
}

TEST_F(Png, StandardViewIsTheSrgbCurve)
{
    Image image{256, 1, 3, {}};
    for (int i = 0; i < 256; ++i)
        for (float scale : {1.0f, 0.5f, 0.1f})
            image.data.push_back(scale * float(i) / 255.0f);
    const auto values = shown(image);
    for (size_t i = 0; i < image.data.size(); ++i)
        ASSERT_NEAR(values[i], srgbCode(image.data[i]), 1) << image.data[i];
    EXPECT_EQ(values[3 * 255], 255);
    EXPECT_EQ(values[0], 0);
}

TEST_F(Png, ColoursAreNotMixedAndOutOfRangeIsClamped)
{
    EXPECT_EQ(shown(constant(1, 1, {1, 0, 0})), (std::vector<int>{255, 0, 0}));
    EXPECT_EQ(shown(constant(1, 1, {0, 9, -3})), (std::vector<int>{0, 255, 0}));
}

TEST_F(Png, ExposureIsInStops)
{
    EXPECT_EQ(shown(constant(1, 1, {0.1f, 0.1f, 0.1f}), {"", "", "", 2.0f}), shown(constant(1, 1, {0.4f, 0.4f, 0.4f})));
}

TEST_F(Png, AcesViewPutsMiddleGreyAtOneTenthAndWhiteBelowFull)
{
    // The output transform maps 0.18 to 4.8 nits of 48, i.e. a tenth of white.  [SMPTE ST 2065-1; ACES RRT/ODT v1]
    const auto grey = shown(constant(1, 1, {0.18f, 0.18f, 0.18f}), {"", "sRGB", "ACES", 0});
    for (int value : grey)
        EXPECT_NEAR(value, srgbCode(0.10), 3);
    EXPECT_LT(shown(constant(1, 1, {1, 1, 1}), {"", "", "ACES", 0})[0], 240);
}

TEST_F(Png, OneChannelIsGreyAndInvalidPixelsAreBlack)
{
    EXPECT_EQ(shown(constant(2, 2, {1})), std::vector<int>(12, 255));
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    Image image = constant(3, 1, {1, 1, 1});
    image.data[1] = nan;
    image.data[5] = -infinity;
    EXPECT_EQ(shown(image), (std::vector<int>{0, 0, 0, 0, 0, 0, 255, 255, 255}));
    EXPECT_EQ(shown(constant(1, 1, {3e38f, 0, 0}), {"", "", "", 10}), (std::vector<int>{0, 0, 0}));
}

TEST_F(Png, AUsersConfigIsUsed)
{
    const auto own =
        config("ocio_profile_version: 2\nsearch_path: \"\"\nroles: {default: raw, scene_linear: lin_rec709}\n"
               "file_rules:\n  - !<Rule> {name: Default, colorspace: default}\n"
               "displays:\n  half:\n    - !<View> {name: darker, colorspace: halved}\n"
               "colorspaces:\n  - !<ColorSpace> {name: raw}\n  - !<ColorSpace> {name: lin_rec709}\n"
               "  - !<ColorSpace>\n    name: halved\n    from_scene_reference: !<MatrixTransform> "
               "{matrix: [0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 0.5, 0, 0, 0, 0, 1]}\n");
    EXPECT_EQ(shown(constant(1, 1, {1.0f, 0.4f, 0.0f}), {own.string(), "", "", 0}), (std::vector<int>{128, 51, 0}));
}

TEST_F(Png, WrongChoicesAreNamedWithTheRightOnes)
{
    const auto error = [&](const DisplayTransform& transform) {
        return errorOf([&] { writePng(folder_ / "b.png", constant(1, 1, {1, 1, 1}), transform); });
    };
    EXPECT_TRUE(contains(error({"", "P3", "", 0}), "it has no display 'P3'; choose from sRGB"))
        << error({"", "P3", "", 0});
    EXPECT_TRUE(contains(error({"", "", "Filmic", 0}), "no view 'Filmic'; choose from Standard, ACES"));
    EXPECT_TRUE(contains(error({"none.ocio", "", "", 0}), "none.ocio: cannot use it as an OpenColorIO config"));
    const std::string broken = error({config("displays: [").string(), "", "", 0});
    EXPECT_TRUE(contains(broken, "own.ocio: cannot use it")) << broken;
    EXPECT_EQ(broken.find('\n'), std::string::npos);
    EXPECT_FALSE(fs::exists(folder_ / "b.png"));
}

TEST_F(Png, AFailedWriteNamesTheFileAndLeavesNothingBehind)
{
    const auto error = [&](const fs::path& file, const Image& image) {
        return errorOf([&] { writePng(file, image); });
    };
    EXPECT_TRUE(contains(error(folder_ / "none/a.png", constant(1, 1, {1, 1, 1})), "create it first"));
    EXPECT_TRUE(contains(error(folder_ / "a.png", constant(1, 1, {1, 1})), "1 or 3 channels, the image is 1x1x2"));
    EXPECT_TRUE(contains(error(folder_ / "a.png", {}), "a.png: cannot write"));
    EXPECT_EQ(filesInFolder(), 0u);
}

}  // namespace
}  // namespace restirpg
