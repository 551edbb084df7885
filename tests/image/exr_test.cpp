// EXR files: what is written is what is read.
#include "fixture.h"

#include "core/log.h"
#include "image/image.h"

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfTiledOutputFile.h>

#include <cmath>
#include <limits>
#include <optional>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

class Exr : public FolderTest {};

TEST_F(Exr, FloatRoundTripIsExactForEveryValueInfinitiesToo)
{
    Image image = ramp(7, 5, 3);
    image.data[0] = std::numeric_limits<float>::infinity();
    image.data[1] = 1e-40f;
    image.data[2] = 3.0e38f;
    writeExr(folder_ / "a.exr", {{"", image}}, PixelType::full);
    const Image read = readExr(folder_ / "a.exr");
    EXPECT_EQ(read.width, 7u);
    EXPECT_EQ(read.height, 5u);
    EXPECT_EQ(read.channels, 3u);
    EXPECT_EQ(read.data, image.data);
}

TEST_F(Exr, HalfRoundTripIsExactForHalfValuesAndSaturatesBeyond)
{
    Image image = ramp(4, 3, 3);
    image.data[5] = 1e6f;
    image.data[6] = -1e6f;
    writeExr(folder_ / "a.exr", {{"", image}}, PixelType::half);
    image.data[5] = 65504.0f;
    image.data[6] = -65504.0f;
    EXPECT_EQ(readExr(folder_ / "a.exr").data, image.data);
    const auto said = saidWarnings();
    EXPECT_TRUE(contains(said.back(), "a.exr: 2 values beyond +-65504"));
}

TEST_F(Exr, LayersOfEveryChannelCountAreReadByName)
{
    writeExr(folder_ / "a.exr",
             {{"", ramp(3, 2, 3)}, {"depth", ramp(3, 2, 1)}, {"motion", ramp(3, 2, 2)}, {"rgba", ramp(3, 2, 4)}},
             PixelType::full);
    const auto pixel = [&](const std::string& layer) {
        const Image image = readExr(folder_ / "a.exr", layer);
        return std::vector<float>{image.at(1, 0, 0), image.at(1, 0, 1), image.at(1, 0, 2)};
    };
    EXPECT_EQ(pixel(""), (std::vector<float>{-1.25f, -1.0f, -0.75f}));
    EXPECT_EQ(pixel("depth"), (std::vector<float>{-1.75f, -1.75f, -1.75f}));
    EXPECT_EQ(pixel("motion"), (std::vector<float>{-1.5f, -1.25f, 0.0f}));
    EXPECT_EQ(pixel("rgba"), (std::vector<float>{-1.0f, -0.75f, -0.5f}));
    const std::string error = errorOf([&] { readExr(folder_ / "a.exr", "normal"); });
    EXPECT_TRUE(contains(error, "no channels normal.R, normal.G, normal.B and no normal.Y; it has B, G, R")) << error;
}

TEST_F(Exr, AttributesRoundTripAndLeaveTheLibrarysOwnAlone)
{
    const std::map<std::string, std::string> attributes = {
        {"graph", "{\"passes\": []}"}, {"seed", "7"}, {"an attribute whose name is longer than 31", "kept"}};
    writeExr(folder_ / "a.exr", {{"", ramp(2, 2, 3)}}, PixelType::half, attributes);
    EXPECT_EQ(readExrAttributes(folder_ / "a.exr"), attributes);
}

TEST_F(Exr, SameContentsGiveTheSameBytes)
{
    for (const char* name : {"a.exr", "b.exr"})
        writeExr(folder_ / name, {{"", ramp(9, 9, 3)}}, PixelType::full, {{"seed", "1"}});
    EXPECT_EQ(readBytes(folder_ / "a.exr"), readBytes(folder_ / "b.exr"));
}

/// A file of one row or more of float channels, whose values are those of `image` in the header's data window.
void write(const fs::path& file, Imf::Header header, const Image& image, const std::vector<std::string>& names)
{
    Imf::FrameBuffer pixels;
    for (size_t c = 0; c < names.size(); ++c) {
        header.channels().insert(names[c], Imf::Channel(Imf::FLOAT));
        pixels.insert(names[c], Imf::Slice::Make(Imf::FLOAT, image.data.data() + c, header.dataWindow(),
                                                 4 * image.channels, 4 * image.channels * image.width));
    }
    Imf::OutputFile output(file.c_str(), header);
    output.setFrameBuffer(pixels);
    output.writePixels(int(image.height));
}

Imf::Header header(const Imath::Box2i& display, const Imath::Box2i& data)
{
    return {display, data};
}

TEST_F(Exr, WhatTheDataWindowLeavesOutOfTheDisplayWindowIsBlack)
{
    // 2 x 3 pixels of a picture of 5 x 4 whose corner is (10, -1).
    write(folder_ / "a.exr", header({{10, -1}, {14, 2}}, {{11, 0}, {12, 2}}), {2, 3, 1, {1, 2, 3, 4, 5, 6}}, {"Y"});
    const Image image = readExr(folder_ / "a.exr");
    ASSERT_EQ(image.width, 5u);
    ASSERT_EQ(image.height, 4u);
    std::vector<float> expected;
    for (const float y : {0, 0, 0, 0, 0, 0, 1, 2, 0, 0, 0, 3, 4, 0, 0, 0, 5, 6, 0, 0})
        expected.insert(expected.end(), 3, y);
    EXPECT_EQ(image.data, expected);
    EXPECT_TRUE(contains(saidWarnings().back(), "a.exr: its pixels cover only a part of its display window"));
}

TEST_F(Exr, WhatTheDataWindowHasBeyondTheDisplayWindowIsLeftOut)
{
    write(folder_ / "a.exr", header({{0, 0}, {0, 1}}, {{-1, -1}, {1, 1}}), {3, 3, 1, {1, 2, 3, 4, 5, 6, 7, 8, 9}},
          {"Y"});
    EXPECT_EQ(readExr(folder_ / "a.exr").data, (std::vector<float>{5, 5, 5, 8, 8, 8}));
    write(folder_ / "b.exr", header({{0, 0}, {1, 0}}, {{1000000000, 7}, {1000000001, 7}}), {2, 1, 1, {1, 2}}, {"Y"});
    EXPECT_EQ(readExr(folder_ / "b.exr").data, std::vector<float>(6, 0.0f));
}

TEST_F(Exr, AHugeDisplayWindowIsRefused)
{
    for (const int right : {70000, 60000, 1000000000}) {
        write(folder_ / "a.exr", header({{0, 0}, {right, 60000}}, {{0, 0}, {1, 0}}), {2, 1, 1, {1, 2}}, {"Y"});
        const std::string error = errorOf([&] { readExr(folder_ / "a.exr"); });
        EXPECT_TRUE(contains(error, "a.exr: cannot read: the header claims")) << error;
    }
}

/// The only pixel of a file with these chromaticities.
class Colours : public FolderTest {
protected:
    std::vector<float> read(const Imf::Chromaticities& chromaticities, std::vector<float> rgb,
                            std::optional<Imath::V2f> neutral = {})
    {
        Imf::Header header(1, 1);
        Imf::addChromaticities(header, chromaticities);
        if (neutral)
            Imf::addAdoptedNeutral(header, *neutral);
        write(folder_ / "a.exr", header, {1, 1, 3, std::move(rgb)}, {"R", "G", "B"});
        return readExr(folder_ / "a.exr").data;
    }
};

void expectNear(const std::vector<float>& values, const std::vector<float>& expected, float tolerance = 1e-4f)
{
    ASSERT_EQ(values.size(), expected.size());
    for (size_t i = 0; i < values.size(); ++i)
        EXPECT_NEAR(values[i], expected[i], tolerance) << i;
}

const Imf::Chromaticities AP1{{0.713f, 0.293f}, {0.165f, 0.83f}, {0.128f, 0.044f}, {0.32168f, 0.33767f}};
const Imf::Chromaticities AP0{{0.7347f, 0.2653f}, {0, 1}, {0.0001f, -0.077f}, {0.32168f, 0.33767f}};
const Imf::Chromaticities P3{{0.68f, 0.32f}, {0.265f, 0.69f}, {0.15f, 0.06f}, {0.3127f, 0.329f}};

TEST_F(Colours, OfOtherPrimariesBecomeRec709)
{
    // The published matrices, with Bradford's adaptation from D60.  [ACES 1.3 CTL; SMPTE RP 431-2]
    expectNear(read(AP1, {1, 0, 0}), {1.70505f, -0.13026f, -0.02400f});
    expectNear(read(AP1, {0, 1, 0}), {-0.62179f, 1.14080f, -0.12897f});
    expectNear(read(AP0, {1, 0, 0}), {2.52169f, -0.27648f, -0.01538f});
    expectNear(read(P3, {1, 0, 0}), {1.22494f, -0.04206f, -0.01964f});
    for (const auto& space : {AP1, AP0, P3})
        expectNear(read(space, {2, 2, 2}), {2, 2, 2});
}

TEST_F(Colours, OfRec709AreLeftExactlyAsTheyAre)
{
    EXPECT_EQ(read(Imf::Chromaticities(), {0.1f, -7, 3e38f}), (std::vector<float>{0.1f, -7, 3e38f}));
}

TEST_F(Colours, OfCieXyzAreNotAdapted)
{
    const Imf::Chromaticities xyz{{1, 0}, {0, 1}, {0, 0}, {1.0f / 3, 1.0f / 3}};
    expectNear(read(xyz, {0.412391f, 0.212639f, 0.019331f}), {1, 0, 0}, 3e-4f);
    expectNear(read(xyz, {0.950456f, 1, 1.089058f}), {1, 1, 1}, 3e-4f);
}

TEST_F(Colours, TheAdoptedNeutralBecomesWhite)
{
    // Rec.709 primaries balanced for illuminant A: its chromaticity, as RGB, becomes grey.
    const float x = 0.44757f, y = 0.40745f;
    const Imath::V3f lampXyz(x / y, 1, (1 - x - y) / y);
    const Imath::V3f lamp = lampXyz * Imf::XYZtoRGB(Imf::Chromaticities(), 1);
    expectNear(read({}, {lamp.x, lamp.y, lamp.z}, Imath::V2f(x, y)), {1, 1, 1});
}

TEST_F(Colours, ThatSpanNothingAreOneLine)
{
    const float nan = std::numeric_limits<float>::quiet_NaN();
    for (const Imf::Chromaticities& wrong :
         {Imf::Chromaticities{{0, 0}, {0, 0}, {0, 0}, {0, 0}},
          Imf::Chromaticities{{0.1f, 0.1f}, {0.2f, 0.2f}, {0.3f, 0.3f}},
          Imf::Chromaticities{{0.64f, 0.33f}, {0.3f, 0.6f}, {0.15f, 0.06f}, {0.3f, 0}},
          Imf::Chromaticities{{nan, 0.33f}, {0.3f, 0.6f}, {0.15f, 0.06f}}}) {
        const std::string error = errorOf([&] { read(wrong, {1, 1, 1}); });
        EXPECT_TRUE(contains(error, "a.exr: cannot read: its chromaticities")) << error;
        EXPECT_EQ(error.find('\n'), error.npos) << error;
    }
}

TEST_F(Exr, LuminanceAndChromaBecomeColours)
{
    for (const auto& chromaticities : {Imf::Chromaticities(), P3}) {
        Imf::Header header(8, 6);
        Imf::addChromaticities(header, chromaticities);
        const std::vector<Imf::Rgba> pixels(48, Imf::Rgba(0.25f, 0.5f, 0.75f));
        {
            Imf::RgbaOutputFile output((folder_ / "a.exr").c_str(), header, Imf::WRITE_YC);
            output.setYCRounding(10, 10);
            output.setFrameBuffer(pixels.data(), 1, 8);
            output.writePixels(6);
        }
        const Image image = readExr(folder_ / "a.exr");
        write(folder_ / "rgb.exr", header, constant(8, 6, {0.25f, 0.5f, 0.75f}), {"R", "G", "B"});
        expectNear(image.data, readExr(folder_ / "rgb.exr").data, 2e-3f);
    }
}

TEST_F(Exr, ChromaOfFullResolutionIsReadToo)
{
    // Y = 0.2126 R + 0.7152 G + 0.0722 B of (0.25, 0.5, 0.75); RY = R/Y - 1.
    const float luminance = 0.2126f * 0.25f + 0.7152f * 0.5f + 0.0722f * 0.75f;
    write(folder_ / "a.exr", Imf::Header(1, 1), {1, 1, 3, {luminance, 0.25f / luminance - 1, 0.75f / luminance - 1}},
          {"Y", "RY", "BY"});
    expectNear(readExr(folder_ / "a.exr").data, {0.25f, 0.5f, 0.75f});
}

TEST_F(Exr, HalfFloatAndUnsignedChannelsAreReadAsTheNumbersTheyAre)
{
    Imf::Header header(2, 1);
    const std::vector<half> red = {half(0.5f), half(2)};
    const std::vector<float> green = {0.1f, 3e5f};
    const std::vector<uint32_t> blue = {7, 4000000000u};
    Imf::FrameBuffer pixels;
    const auto add = [&](const char* name, Imf::PixelType type, const void* data, size_t size) {
        header.channels().insert(name, Imf::Channel(type));
        pixels.insert(name, Imf::Slice(type, static_cast<char*>(const_cast<void*>(data)), size, 2 * size));
    };
    add("R", Imf::HALF, red.data(), 2);
    add("G", Imf::FLOAT, green.data(), 4);
    add("B", Imf::UINT, blue.data(), 4);
    {
        Imf::OutputFile output((folder_ / "a.exr").c_str(), header);
        output.setFrameBuffer(pixels);
        output.writePixels(1);
    }
    EXPECT_EQ(readExr(folder_ / "a.exr").data, (std::vector<float>{0.5f, 0.1f, 7, 2, 3e5f, 4e9f}));
}

TEST_F(Exr, NamesMayBeLowerCaseOrOfTheOnlyLayer)
{
    const Image image = ramp(3, 2, 3);
    using Names = std::vector<std::string>;
    for (const Names& names :
         {Names{"r", "g", "b"}, Names{"red", "green", "blue"}, Names{"beauty.R", "beauty.G", "beauty.B"},
          Names{"ViewLayer.Combined.R", "ViewLayer.Combined.G", "ViewLayer.Combined.B"}}) {
        write(folder_ / "a.exr", Imf::Header(3, 2), image, names);
        EXPECT_EQ(readExr(folder_ / "a.exr").data, image.data) << names[0];
    }
}

TEST_F(Exr, OfManyLayersCombinedIsThePictureAndWithoutItOneMustBeNamed)
{
    Image image = ramp(3, 2, 6);
    write(folder_ / "a.exr", Imf::Header(3, 2), image,
          {"A.AO.R", "A.AO.G", "A.AO.B", "A.Combined.R", "A.Combined.G", "A.Combined.B"});
    EXPECT_EQ(readExr(folder_ / "a.exr").at(0, 0, 0), image.data[3]);
    EXPECT_EQ(readExr(folder_ / "a.exr", "A.AO").at(0, 0, 0), image.data[0]);
    write(folder_ / "b.exr", Imf::Header(3, 2), image, {"AO.R", "AO.G", "AO.B", "beauty.R", "beauty.G", "beauty.B"});
    const std::string error = errorOf([&] { readExr(folder_ / "b.exr"); });
    EXPECT_TRUE(contains(error, "it has AO.B, AO.G, AO.R, beauty.B")) << error;
}

TEST_F(Exr, SubsampledColoursAreRefusedByName)
{
    Imf::Header header(2, 2);
    std::vector<float> values(4, 1);
    Imf::FrameBuffer pixels;
    for (const char* name : {"R", "G", "B"}) {
        const int sampling = *name == 'B' ? 2 : 1;
        header.channels().insert(name, Imf::Channel(Imf::FLOAT, sampling, sampling));
        pixels.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 8, sampling, sampling));
    }
    {
        Imf::OutputFile output((folder_ / "a.exr").c_str(), header);
        output.setFrameBuffer(pixels);
        output.writePixels(2);
    }
    const std::string error = errorOf([&] { readExr(folder_ / "a.exr"); });
    EXPECT_TRUE(contains(error, "a.exr: cannot read: channel B is subsampled")) << error;
}

TEST_F(Exr, TiledFilesAreRead)
{
    Imf::Header header(5, 4);
    header.setTileDescription(Imf::TileDescription(2, 2));
    const Image image = ramp(5, 4, 3);
    Imf::FrameBuffer pixels;
    for (int c = 0; c < 3; ++c) {
        const char* name = std::array{"R", "G", "B"}[size_t(c)];
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        pixels.insert(name, Imf::Slice(Imf::FLOAT, (char*)(image.data.data() + c), 12, 60));
    }
    {
        Imf::TiledOutputFile output((folder_ / "a.exr").c_str(), header);
        output.setFrameBuffer(pixels);
        output.writeTiles(0, output.numXTiles() - 1, 0, output.numYTiles() - 1);
    }
    EXPECT_EQ(readExr(folder_ / "a.exr").data, image.data);
}

TEST_F(Exr, OfAMultiPartFileTheFirstPartWithColoursIsRead)
{
    std::vector<Imf::Header> headers(3, Imf::Header(1, 1));
    const std::vector<std::vector<const char*>> names = {{"Z"}, {"R", "G", "B"}, {"R", "G", "B"}};
    for (size_t part = 0; part < 3; ++part) {
        headers[part].setName("part" + std::to_string(part));
        headers[part].setType(Imf::SCANLINEIMAGE);
        for (const char* name : names[part])
            headers[part].channels().insert(name, Imf::Channel(Imf::FLOAT));
    }
    {
        Imf::MultiPartOutputFile file((folder_ / "a.exr").c_str(), headers.data(), 3);
        for (size_t part = 0; part < 3; ++part) {
            float value = float(part);
            Imf::OutputPart output(file, int(part));
            Imf::FrameBuffer pixels;
            for (const char* name : names[part])
                pixels.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(&value), 4, 4));
            output.setFrameBuffer(pixels);
            output.writePixels(1);
        }
    }
    EXPECT_EQ(readExr(folder_ / "a.exr").data, (std::vector<float>{1, 1, 1}));
    EXPECT_EQ(readExr(folder_ / "a.exr", "part2").data, (std::vector<float>{2, 2, 2}));
}

TEST_F(Exr, OfAMultiPartFileTheFirstPartIsRead)
{
    std::vector<Imf::Header> headers(2, Imf::Header(2, 1));
    for (int part = 0; part < 2; ++part) {
        headers[size_t(part)].setName("part" + std::to_string(part));
        headers[size_t(part)].setType(Imf::SCANLINEIMAGE);
        headers[size_t(part)].channels().insert("Y", Imf::Channel(Imf::FLOAT));
    }
    {
        Imf::MultiPartOutputFile file((folder_ / "a.exr").c_str(), headers.data(), 2);
        for (int part = 0; part < 2; ++part) {
            std::vector<float> values(2, float(part + 5));
            Imf::OutputPart output(file, part);
            Imf::FrameBuffer pixels;
            pixels.insert("Y", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(values.data()), 4, 8));
            output.setFrameBuffer(pixels);
            output.writePixels(1);
        }
    }
    EXPECT_EQ(readExr(folder_ / "a.exr").at(1, 0, 0), 5.0f);
}

TEST_F(Exr, ADeepFileIsOneClearError)
{
    Imf::Header header(1, 1);
    header.setType(Imf::DEEPSCANLINE);
    header.compression() = Imf::ZIPS_COMPRESSION;
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    {
        unsigned int count = 1;
        float value = 1;
        float* samples = &value;
        Imf::DeepScanLineOutputFile output((folder_ / "deep.exr").c_str(), header);
        Imf::DeepFrameBuffer pixels;
        pixels.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(&count), 4, 4));
        pixels.insert("Y", Imf::DeepSlice(Imf::FLOAT, reinterpret_cast<char*>(&samples), 8, 8, 4));
        output.setFrameBuffer(pixels);
        output.writePixels(1);
    }
    const std::string error = errorOf([&] { readExr(folder_ / "deep.exr"); });
    EXPECT_TRUE(contains(error, "deep.exr: cannot read: deep images are not supported")) << error;
}

TEST_F(Exr, AFailedWriteNamesTheFileAndLeavesNothingBehind)
{
    const fs::path file = folder_ / "a.exr";
    const auto write = [&](const fs::path& to, std::vector<Layer> layers) {
        return errorOf([&] { writeExr(to, layers, PixelType::full); });
    };
    EXPECT_TRUE(contains(write(folder_ / "none/a.exr", {{"", ramp(2, 2, 3)}}), "none does not exist; create it first"));
    EXPECT_TRUE(contains(write(folder_, {{"", ramp(2, 2, 3)}}), "it is a folder"));
    EXPECT_TRUE(contains(write(file, {}), "a.exr: cannot write: no layers"));
    EXPECT_TRUE(
        contains(write(file, {{"", ramp(2, 2, 3)}, {"n", ramp(3, 2, 3)}}), "layer 'n' is 3x2 and the first layer 2x2"));
    EXPECT_TRUE(contains(write(file, {{"", ramp(2, 2, 5)}}), "has 5 channels"));
    EXPECT_TRUE(contains(write(file, {{"n", Image{2, 2, 3, {}}}}), "layer 'n' has 0 values, not 2x2x3"));
    EXPECT_EQ(filesInFolder(), 0u);
}

TEST_F(Exr, AFailedWriteKeepsTheFileThatWasThere)
{
    const fs::path file = folder_ / "a.exr";
    writeExr(file, {{"", ramp(2, 2, 3)}}, PixelType::full);
    const auto before = readBytes(file);
    EXPECT_NE(errorOf([&] { writeExr(file, {{"", ramp(2, 2, 3)}, {"n", ramp(3, 2, 3)}}, PixelType::full); }), "");
    EXPECT_EQ(readBytes(file), before);
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(Exr, AsRadianceInfinitiesSaturateAndTheRestThatIsNoRadianceIsZero)
{
    const float infinity = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
    write(folder_ / "a.exr", Imf::Header(2, 1), {2, 1, 3, {infinity, 2, nan, -1, -infinity, 0}}, {"R", "G", "B"});
    EXPECT_EQ(readRadiance(folder_ / "a.exr").data, (std::vector<float>{65504, 2, 0, 0, 0, 0}));
    write(folder_ / "sun.exr", Imf::Header(2, 1), {2, 1, 3, {infinity, 3e5f, 0, 1, 1, 1}}, {"R", "G", "B"});
    EXPECT_EQ(readRadiance(folder_ / "sun.exr").data, (std::vector<float>{3e5f, 3e5f, 0, 1, 1, 1}));
    std::string said;
    for (const auto& warning : saidWarnings())
        said += warning + "\n";
    EXPECT_TRUE(contains(said, "a.exr: 2 infinite values are read as 65504; write full floats"));
    EXPECT_TRUE(contains(said, "a.exr: 1 values that are not numbers (NaN) are read as 0"));
    EXPECT_TRUE(contains(said, "a.exr: 2 negative values are read as 0"));
    EXPECT_TRUE(contains(said, "sun.exr: 1 infinite values are read as 300000"));
}

TEST_F(Exr, AnInfinityOfOtherPrimariesStaysASun)
{
    const float infinity = std::numeric_limits<float>::infinity();
    Imf::Header header(1, 1);
    Imf::addChromaticities(header, AP1);
    write(folder_ / "a.exr", header, {1, 1, 3, {infinity, infinity, infinity}}, {"R", "G", "B"});
    expectNear(readRadiance(folder_ / "a.exr").data, {65504, 65504, 65504}, 1);
}

}  // namespace
}  // namespace restirpg
