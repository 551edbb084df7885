// What a scene may read: data URIs, and files at or below its own folder, however they are named.
#include "gltf_builder.h"

#include "scene/gltf.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

using namespace restirpg;
namespace fs = std::filesystem;

namespace {

/// A folder with a scene's folder in it and a file beside that.
class Uris : public testing::Test {
protected:
    void SetUp() override
    {
        top_ = scratch() / testing::UnitTest::GetInstance()->current_test_info()->name();
        folder_ = top_ / "scene";
        fs::create_directories(folder_ / "sub");
        writeBytes(top_ / "secret.bin", triangle());
        writeBytes(folder_ / "mine.bin", triangle());
        writeBytes(folder_ / "sub" / "deep.bin", triangle());
    }

    static std::vector<uint8_t> triangle()
    {
        const float corners[] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
        std::vector<uint8_t> bytes(sizeof corners);
        std::memcpy(bytes.data(), corners, sizeof corners);
        return bytes;
    }

    /// A scene whose only buffer is `uri`.
    fs::path sceneWith(const std::string& uri, size_t byteLength = 36) const
    {
        GltfBuilder builder;
        builder.json["buffers"] = {{{"byteLength", byteLength}, {"uri", uri}}};
        builder.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
        const int positions =
            builder.addAccessorJson({{"bufferView", 0}, {"componentType", FLOAT}, {"count", 3}, {"type", "VEC3"}});
        builder.addNode({{"mesh", builder.addMesh({{"attributes", {{"POSITION", positions}}}})}});
        return builder.write(folder_ / "scene.gltf");
    }

    void expectLoads(const std::string& uri, size_t byteLength = 36) const
    {
        const auto scene = loadGltf(sceneWith(uri, byteLength));
        ASSERT_EQ(scene.positions.size(), 3u) << uri;
        EXPECT_EQ(scene.positions[1], glm::vec3(1, 0, 0)) << uri;
    }

    void expectRefused(const std::string& uri, const std::string& reason) const
    {
        const auto message = errorOf([&] { loadGltf(sceneWith(uri)); });
        EXPECT_NE(message.find("scene.gltf: buffers[0]: "), message.npos) << message;
        EXPECT_NE(message.find(reason), message.npos) << message;
    }

    fs::path top_, folder_;
};

constexpr const char* OUTSIDE = "lies outside of the scene's folder";

}  // namespace

TEST_F(Uris, FilesAtOrBelowTheFolderAreRead)
{
    for (const char* uri : {"mine.bin", "./mine.bin", "%6dine.bin", "sub/deep.bin", "sub/../mine.bin", "sub%2fdeep.bin",
                            R"(sub\deep.bin)"})
        expectLoads(uri);
    expectLoads((folder_ / "mine.bin").string());
    expectLoads("file://" + (folder_ / "mine.bin").string());
    fs::create_symlink("sub/deep.bin", folder_ / "link.bin");
    expectLoads("link.bin");
    writeBytes(folder_ / "100%.bin", triangle());
    expectLoads("100%.bin");
    expectLoads("100%25.bin");
}

TEST_F(Uris, FilesOutsideAreRefusedHoweverTheyAreNamed)
{
    const auto secret = (top_ / "secret.bin").string();
    fs::create_symlink("../secret.bin", folder_ / "link.bin");
    fs::create_symlink("..", folder_ / "up");
    for (const auto& uri :
         {std::string("../secret.bin"), std::string("%2e%2e/secret.bin"), std::string("%2E%2E%2Fsecret.bin"),
          std::string("sub/../../secret.bin"), std::string("missing/../../secret.bin"), secret, "file://" + secret,
          "file:" + secret, "FILE://localhost" + secret, std::string("link.bin"), std::string("up/secret.bin"),
          std::string("../scene2/../secret.bin")})
        expectRefused(uri, OUTSIDE);
    // A folder whose name only begins like the scene's is another one.
    fs::create_directories(top_ / "scene2");
    writeBytes(top_ / "scene2" / "a.bin", triangle());
    expectRefused("../scene2/a.bin", OUTSIDE);
}

TEST_F(Uris, OutsideIsReadWhereTheUserAllowsIt)
{
    EXPECT_EQ(loadGltf(sceneWith("../secret.bin"), true).positions.size(), 3u);
}

TEST_F(Uris, ASceneInALinkedFolderReadsItsOwnFiles)
{
    sceneWith("mine.bin");
    fs::create_directory_symlink(folder_, top_ / "link");
    EXPECT_EQ(loadGltf(top_ / "link" / "scene.gltf").positions.size(), 3u);
}

TEST_F(Uris, ImagesAndEnvironmentsKeepToTheFolderToo)
{
    auto builder = squareScene();
    builder.json["images"] = {{{"uri", "../secret.png"}}};
    EXPECT_NE(errorOf([&] { loadGltf(builder.write(folder_ / "a.glb")); }).find(OUTSIDE), std::string::npos);
    builder = squareScene();
    builder.json["asset"]["extras"]["restirpg"] = {{"environment", "../sky.exr"}};
    EXPECT_NE(errorOf([&] { loadGltf(builder.write(folder_ / "a.glb")); }).find(OUTSIDE), std::string::npos);
}

TEST_F(Uris, PipesDevicesAndFoldersAreRefusedAtOnce)
{
    ASSERT_EQ(mkfifo((folder_ / "pipe").c_str(), 0600), 0);
    expectRefused("pipe", "not a regular file");
    expectRefused("sub", "not a regular file");
    const auto device = errorOf([&] { loadGltf(sceneWith("/dev/zero"), true); });
    EXPECT_NE(device.find("not a regular file"), device.npos) << device;
    EXPECT_NE(errorOf([&] { loadGltf(folder_ / "pipe"); }).find("not a file"), std::string::npos);
}

TEST_F(Uris, OtherMachinesAndNonsenseAreOneLine)
{
    expectRefused("https://example.org/a.bin", "another machine");
    expectRefused("//server/share/a.bin", "another machine");
    expectRefused("mine.bin%00.png", "names no file");
    expectRefused("", "names no file");
    EXPECT_NE(errorOf([&] { loadGltf(sceneWith("gone.bin")); }).find("no such file"), std::string::npos);
}

TEST_F(Uris, DataUrisOfAnyMediaTypeAreRead)
{
    const auto base64 = encodeBase64(triangle());
    for (const char* header :
         {"data:application/octet-stream;base64,", "data:application/gltf-buffer;base64,", "data:;base64,",
          "data:text/plain;charset=utf-8;base64,", "data:application/x-binary;base64,", "DATA:model/vnd.x;BASE64,"})
        expectLoads(header + base64);
    auto escaped = base64;
    for (size_t at; (at = escaped.find('/')) != escaped.npos;)
        escaped.replace(at, 1, "%2F");
    expectLoads("data:;base64," + escaped);
    std::string percent = "data:,";
    for (const uint8_t byte : triangle())
        percent += fmt::format("%{:02x}", byte);
    expectLoads(percent);
}

TEST_F(Uris, BuffersMayBeLongerThanTheyDeclare)
{
    auto longer = triangle();
    longer.resize(100, 7);
    writeBytes(folder_ / "longer.bin", longer);
    expectLoads("longer.bin");
    expectLoads("data:application/octet-stream;base64," + encodeBase64(longer));
    const auto message = errorOf([&] { loadGltf(sceneWith("longer.bin", 101)); });
    EXPECT_NE(message.find("buffers[0]: has 100 bytes, but byteLength is 101"), message.npos) << message;
}

TEST_F(Uris, GlbChunksMayBePaddedAndFollowedByOthers)
{
    const auto whole = readBytes(squareScene().write(folder_ / "a.glb"));
    const auto withTail = [&](size_t padding, bool third) {
        auto bytes = whole;
        const auto word = [&](size_t at) { return reinterpret_cast<uint32_t*>(bytes.data() + at); };
        const size_t binary = 20 + *word(12);
        *word(binary) += uint32_t(padding);
        bytes.resize(bytes.size() + padding);
        if (third)
            for (const char* part : {"\x04\x00\x00\x00", "XTRA", "abcd"})
                bytes.insert(bytes.end(), part, part + 4);
        *word(8) = uint32_t(bytes.size());
        writeBytes(folder_ / "b.glb", bytes);
        return loadGltf(folder_ / "b.glb").triangles.size();
    };
    for (const size_t padding : {0, 4, 400})
        for (const bool third : {false, true})
            EXPECT_EQ(withTail(padding, third), 2u) << padding << third;
}

/// The binary chunk may be absent, and chunks of unknown types are no damage [glTF 2.0, 4.4.3].
TEST_F(Uris, AGlbMayHaveAnotherChunkWhereItsBinaryOneCouldBe)
{
    auto text = readBytes(squareScene().write(folder_ / "a.gltf"));
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::vector<uint8_t> bytes(20);
    const uint32_t header[5] = {0x46546c67, 2, uint32_t(20 + text.size() + 12), uint32_t(text.size()), 0x4e4f534a};
    std::memcpy(bytes.data(), header, sizeof header);
    bytes.insert(bytes.end(), text.begin(), text.end());
    for (const char* part : {"\x04\x00\x00\x00", "XTRA", "abcd"})
        bytes.insert(bytes.end(), part, part + 4);
    writeBytes(folder_ / "b.glb", bytes);
    EXPECT_EQ(loadGltf(folder_ / "b.glb").triangles.size(), 2u);
    bytes[20 + text.size()] = 200;
    writeBytes(folder_ / "b.glb", bytes);
    const auto message = errorOf([&] { loadGltf(folder_ / "b.glb"); });
    EXPECT_NE(message.find("second chunk of 200 bytes leaves the file"), message.npos) << message;
}
