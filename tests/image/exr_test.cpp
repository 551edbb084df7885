// EXR files: what is written is what is read.
#include "fixture.h"

#include "core/log.h"

#include <ImfChannelList.h>
#include <ImfDeepFrameBuffer.h>
#include <ImfDeepScanLineOutputFile.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfTiledOutputFile.h>

#include <cmath>
#include <limits>

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

TEST_F(Exr, ADataWindowAwayFromTheOriginIsReadWhole)
{
    Imf::Header header(Imath::Box2i({0, 0}, {99, 99}), Imath::Box2i({-3, 10}, {-2, 12}));
    header.channels().insert("Y", Imf::Channel(Imf::FLOAT));
    std::vector<float> values = {1, 2, 3, 4, 5, 6};
    {
        Imf::OutputFile output((folder_ / "a.exr").c_str(), header);
        Imf::FrameBuffer pixels;
        pixels.insert("Y", Imf::Slice::Make(Imf::FLOAT, values.data(), header.dataWindow(), 4, 8));
        output.setFrameBuffer(pixels);
        output.writePixels(3);
    }
    const Image image = readExr(folder_ / "a.exr");
    ASSERT_EQ(image.width, 2u);
    ASSERT_EQ(image.height, 3u);
    EXPECT_EQ(image.at(1, 2, 0), 6.0f);
    EXPECT_EQ(image.at(0, 1, 2), 3.0f);
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

}  // namespace
}  // namespace restirpg
