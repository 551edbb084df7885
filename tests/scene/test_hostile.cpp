// Damaged and hostile files: always one clear line, never a crash.
#include "hostile.h"

#include "core/log.h"
#include "scene/gltf.h"
#include "scene/gltf_file.h"

#include <limits>

using namespace restirpg;
using nlohmann::json;

namespace {

json& positionsOf(GltfBuilder& builder)
{
    return builder.json["accessors"][size_t(primitiveOf(builder)["attributes"]["POSITION"])];
}

std::string errorOfBytes(const std::vector<uint8_t>& bytes, const char* name = "damaged.glb")
{
    writeBytes(scratch() / name, bytes);
    return errorOf([&] { loadGltf(scratch() / name); });
}

}  // namespace

TEST(Hostile, IndicesOutOfRangeAreNamed)
{
    expectError(
        [](auto& b) {
            primitiveOf(b)["indices"] = b.addAccessor(std::vector<uint16_t>{0, 1, 4}, UNSIGNED_SHORT, "SCALAR");
        },
        {"mesh 0 'Square'", "index 2 is 4", "4 positions"});
    expectError([](auto& b) { primitiveOf(b)["indices"] = 77; },
                {"meshes[0].primitives[0].indices", "77", "accessors"});
    expectError([](auto& b) { primitiveOf(b)["attributes"]["NORMAL"] = -1; }, {"primitives[0].attributes.NORMAL"});
    expectError([](auto& b) { primitiveOf(b)["material"] = 0; }, {"material", "0 elements"});
    expectError([](auto& b) { b.json["nodes"][0]["mesh"] = 3; }, {"nodes[0].mesh"});
    expectError([](auto& b) { b.json["scene"] = 1; }, {"scene: 1"});
    expectError([](auto& b) { b.json["scenes"][0]["nodes"] = {5}; }, {"scenes[0].nodes[0]"});
    expectError([](auto& b) { b.json["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0; },
                {"KHR_lights_punctual"});
    expectError([](auto& b) { b.json["nodes"][0]["camera"] = 0; }, {"nodes[0].camera"});
    expectError([](auto& b) { positionsOf(b)["bufferView"] = 4294967295u; }, {"accessors[0].bufferView"});
}

TEST(Hostile, NanAndInfiniteVerticesAreNamed)
{
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1e20f})
        expectError(
            [&](auto& b) {
                primitiveOf(b)["attributes"]["POSITION"] =
                    b.addAccessor(std::vector<float>{0, 0, 0, 1, bad, 0, 1, 1, 0, 0, 1, 0}, FLOAT, "VEC3");
            },
            {"mesh 0 'Square' POSITION", " 1 "});
    expectError(
        [](auto& b) {
            primitiveOf(b)["attributes"]["TEXCOORD_0"] = b.addAccessor(std::vector<float>(8, NAN), FLOAT, "VEC2");
        },
        {"TEXCOORD_0", "not a finite number"});
}

TEST(Hostile, CountsBeyondTheBufferAreNamed)
{
    expectError([](auto& b) { positionsOf(b)["count"] = 5; }, {"POSITION", "60 bytes", "48"});
    expectError([](auto& b) { positionsOf(b)["count"] = 2147483647; }, {"POSITION"});
    expectError([](auto& b) { positionsOf(b)["count"] = 4e9; }, {"accessors[0].count"});
    expectError([](auto& b) { positionsOf(b)["count"] = -1; }, {"accessors[0].count"});
    expectError([](auto& b) { positionsOf(b)["byteOffset"] = 4; }, {"POSITION"});
    expectError(
        [](auto& b) {
            positionsOf(b).erase("bufferView");
            positionsOf(b)["count"] = 2000000000;
        },
        {"no triangles"});
    expectError([](auto& b) { b.json["bufferViews"][0]["byteLength"] = 1000000; }, {"bufferViews[0]", "1000000"});
    expectError([](auto& b) { b.json["bufferViews"][0]["byteOffset"] = 2000000000; }, {"bufferViews[0]"});
    expectError([](auto& b) { b.json["buffers"] = {{{"byteLength", 2000000000}}}; }, {"byteLength"});
    expectError([](auto& b) { b.json["bufferViews"][0]["byteStride"] = 1000; }, {"byteStride"});
}

TEST(Hostile, WrongTypesAreNamed)
{
    expectError([](auto& b) { positionsOf(b)["type"] = "VEC2"; }, {"POSITION", "VEC2", "VEC3"});
    expectError([](auto& b) { positionsOf(b)["type"] = "VEC9"; }, {"VEC9"});
    expectError([](auto& b) { positionsOf(b)["componentType"] = 5130; }, {"5130"});
    expectError([](auto& b) { primitiveOf(b)["mode"] = 9; }, {"mode 9"});
    expectError([](auto& b) { primitiveOf(b)["attributes"] = 3; }, {"attributes", "an object"});
    expectError([](auto& b) { b.json["materials"] = "none"; }, {"materials", "an array"});
    expectError([](auto& b) { b.json["nodes"][0]["translation"] = {1, 2}; }, {"nodes[0].translation", "3 numbers"});
    expectError([](auto& b) { b.json["nodes"][0]["scale"] = {1, 1e300, 1}; }, {"nodes[0].scale"});
    expectError([](auto& b) { b.json["asset"].erase("version"); }, {"asset", "'version' is missing"});
    expectError([](auto& b) { b.json["asset"]["version"] = "1.0"; }, {"1.0"});
    expectError([](auto& b) { b.json["asset"]["minVersion"] = "2.1"; },
                {"asset.minVersion 2.1: only glTF 2.0 is read"});
    expectError([](auto& b) { b.json["asset"]["minVersion"] = "3.0"; },
                {"asset.minVersion 3.0: only glTF 2.0 is read"});
    expectError([](auto& b) { b.json["asset"]["minVersion"] = 2; }, {"asset.minVersion", "a string"});
    expectError([](auto& b) { b.json["nodes"][0]["name"] = 3; }, {"nodes[0].name"});
}

TEST(Hostile, ScenesWithoutTrianglesAreErrors)
{
    expectError([](auto& b) { primitiveOf(b)["mode"] = 1; }, {"no triangles"});
    expectError([](auto& b) { b.json["nodes"][0].erase("mesh"); }, {"no triangles"});
    expectError([](auto& b) { b.json["nodes"][0]["scale"] = {1e12, 1e12, 1e12}; }, {"reaches beyond 3000000000 m"});
    expectError([](auto& b) { b.json["nodes"][0]["scale"] = {3e9, 3e9, 3e9}; }, {"reaches beyond"});
}

TEST(Hostile, BrokenDataUrisAreOneShortLine)
{
    for (const char* uri : {"data:application/octet-stream;base64,####", "data:application/octet-stream;base64,",
                            "data:,abc", "", "../../../../../../etc/passwd", "/etc/passwd", "."}) {
        auto builder = squareScene();
        builder.json["buffers"] = {{{"byteLength", 4}, {"uri", uri}}};
        EXPECT_LT(errorOf([&] { loadGltf(builder.write(scratch() / "uri.gltf")); }).size(), 500u) << uri;
    }
    auto builder = squareScene();
    builder.json["buffers"] = {
        {{"byteLength", 4}, {"uri", "data:application/octet-stream;base64," + std::string(100000, 'A')}}};
    EXPECT_LT(errorOf([&] { loadGltf(builder.write(scratch() / "uri.gltf")); }).size(), 500u);
}

TEST(Hostile, DeepJsonIsRefused)
{
    const std::string open = R"({"asset":{"version":"2.0","extras":)", deep(100000, '[');
    const auto text = open + deep + std::string(100000, ']') + "}}";
    EXPECT_NE(errorOfBytes({text.begin(), text.end()}, "deep.gltf").find("nested"), std::string::npos);
    const auto unclosed = open + deep;
    EXPECT_NE(errorOfBytes({unclosed.begin(), unclosed.end()}, "deep.gltf").find("nested"), std::string::npos);
}

TEST(Hostile, EveryTruncationIsAnError)
{
    const auto whole = readBytes(squareScene().write(scratch() / "whole.glb"));
    for (size_t size = 0; size < whole.size(); size += 1 + size / 50)
        EXPECT_NE(errorOfBytes({whole.begin(), whole.begin() + long(size)}).find("damaged.glb"), std::string::npos)
            << size;
}

TEST(Hostile, OtherThingsThanFilesAreErrors)
{
    EXPECT_NE(errorOf([] { loadGltf(scratch() / "missing.glb"); }).find("no such file"), std::string::npos);
    EXPECT_NE(errorOf([] { loadGltf(scratch()); }).find("not a file"), std::string::npos);
    EXPECT_NE(errorOf([] { loadGltf("/dev/zero"); }).find("not a file"), std::string::npos);
    EXPECT_NE(errorOfBytes({'[', ']', ' ', ' '}).find("not glTF"), std::string::npos);
}

TEST(Hostile, UnsupportedRequiredExtensionsAreNamed)
{
    expectError([](auto& b) { b.json["extensionsRequired"] = {"EXT_meshopt_compression"}; },
                {"EXT_meshopt_compression"});
}

TEST(Hostile, NamesAreCutBetweenCharacters)
{
    for (size_t first = 0; first < 4; ++first) {
        auto builder = squareScene();
        std::string name(first, 'x');
        for (int i = 0; i < 100; ++i)
            name += "\u5e8a";
        builder.json["meshes"][0]["name"] = name;
        primitiveOf(builder)["mode"] = 9;
        // Strict: throws on a character cut in two.
        EXPECT_NO_THROW(json(errorOf(builder)).dump()) << first;
    }
}

TEST(Hostile, AskingForMoreThanTheMemoryIsRefusedBeforeItIsTaken)
{
    // A sparse accessor counts what the file does not hold.
    auto builder = squareScene();
    auto sparse = positionsOf(builder);
    sparse.erase("bufferView");
    sparse["count"] = 1 << 24;
    sparse["sparse"] = {
        {"count", 1},
        {"indices",
         {{"bufferView", builder.addView(std::vector<uint16_t>{1}.data(), 2)}, {"componentType", UNSIGNED_SHORT}}},
        {"values", {{"bufferView", builder.addView(std::vector<float>{3, 0, 0}.data(), 12)}}}};
    const json primitive = {{"attributes", {{"POSITION", builder.addAccessorJson(sparse)}}}};
    builder.json["meshes"][0]["primitives"] = json::array();
    for (int i = 0; i < 24; ++i)
        builder.json["meshes"][0]["primitives"].push_back(primitive);
    EXPECT_NE(errorOf(builder).find("memory"), std::string::npos);
    builder.json["meshes"][0]["primitives"].push_back(primitive);
    EXPECT_NE(errorOf(builder).find("triangles are more than"), std::string::npos);
    // Without a sparse part all of them lie at the origin.
    expectError(
        [](auto& b) {
            positionsOf(b).erase("bufferView");
            positionsOf(b)["count"] = 1 << 24;
            primitiveOf(b)["attributes"] = {{"POSITION", primitiveOf(b)["attributes"]["POSITION"]}};
        },
        {"no triangles"});
}

TEST(Hostile, SmallFilesOfManyInstancesAreRefused)
{
    GltfBuilder builder;
    const std::vector<float> corners = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    std::vector<uint32_t> indices(3 << 18);
    for (size_t i = 0; i < indices.size(); ++i)
        indices[i] = uint32_t(i % 3);
    builder.addMesh({{"attributes", {{"POSITION", builder.addAccessor(corners, FLOAT, "VEC3")}}},
                     {"indices", builder.addAccessor(indices, UNSIGNED_INT, "SCALAR")}});
    for (int i = 0; i < 2049; ++i)
        builder.addNode({{"mesh", 0}});
    EXPECT_NE(errorOf(builder).find("every instance counted"), std::string::npos);
}

TEST(Hostile, MessagesStayOneLineWhateverTheNames)
{
    expectError(
        [](auto& b) {
            b.json["meshes"][0]["name"] = "a\nb\tc" + std::string(1000, 'x');
            primitiveOf(b)["mode"] = 9;
        },
        {R"(a\nb\tc)", "mode 9"});
}

/// Each channel keeps a copy of its sampler's keys. No channel is large here, but all together are.
TEST_F(HostileInLittleMemory, ManyChannelsOfOneSamplerAreRefusedBeforeTheyAreRead)
{
    auto builder = squareScene();
    const int times = builder.addAccessorJson({{"componentType", FLOAT}, {"count", 1 << 15}, {"type", "SCALAR"}});
    const int moves = builder.addAccessorJson({{"componentType", FLOAT}, {"count", 1 << 15}, {"type", "VEC3"}});
    auto channels = json::array();
    for (int i = 0; i < 600; ++i) {
        const int node = builder.addNode(json::object());
        for (const char* path : {"translation", "scale"})
            channels.push_back({{"sampler", 0}, {"target", {{"node", node}, {"path", path}}}});
    }
    builder.json["animations"] = {{{"samplers", {{{"input", times}, {"output", moves}}}}, {"channels", channels}}};
    limitTo(1);
    const auto message = errorOf(builder);
    EXPECT_NE(message.find("scene.glb: the animation of 1200 channels needs 750.0 MiB of memory"), message.npos)
        << message;
}

/// An accessor without data may count a gibibyte of matrices.
TEST_F(HostileInLittleMemory, OfInverseBindMatricesOnlyThoseOfJointsAreRead)
{
    auto builder = squareScene();
    builder.json["skins"] = {
        {{"joints", {0}},
         {"inverseBindMatrices",
          builder.addAccessorJson({{"componentType", FLOAT}, {"count", 1 << 24}, {"type", "MAT4"}})}}};
    builder.addNode({{"mesh", 0}, {"skin", 0}});
    limitTo(1);
    EXPECT_EQ(load(builder).instances.size(), 2u);
}
