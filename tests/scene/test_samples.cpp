// The sample files of ../shared: every one loads, or gives its one clear line.
#include "gltf_builder.h"

#include "scene/gltf.h"
#include "scene/lights.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

using namespace restirpg;
using nlohmann::json;

namespace {

/// RESTIRPG_SHARED, else ../shared beside the source tree; empty when there is none.
std::filesystem::path sharedFolder()
{
    const char* given = std::getenv("RESTIRPG_SHARED");
    const std::filesystem::path folder = given ? given : RESTIRPG_SOURCE "/../shared";
    return std::filesystem::is_directory(folder / "gltf-samples") ? folder : std::filesystem::path();
}

std::vector<std::filesystem::path> filesIn(const std::filesystem::path& folder)
{
    std::vector<std::filesystem::path> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.path().extension() == ".glb" || entry.path().extension() == ".gltf")
            files.push_back(entry.path());
    std::sort(files.begin(), files.end());
    return files;
}

class Samples : public testing::Test {
protected:
    void SetUp() override
    {
        shared_ = sharedFolder();
        if (shared_.empty())
            GTEST_SKIP() << "the sample scenes are missing: none is read; set RESTIRPG_SHARED to the folder that holds "
                            "gltf-samples/ and scenes/";
    }

    std::filesystem::path shared_;
};

/// Load and check what every consumer relies on.
void expectSound(const std::filesystem::path& file)
{
    SCOPED_TRACE(file.filename().string());
    const auto scene = loadGltf(file);
    const auto pose = poseNodes(scene, 0);
    EXPECT_FALSE(scene.instances.empty());
    EXPECT_EQ(scene.hash.size(), 16u);
    makeCamera(scene.cameras[0], pose[scene.cameras[0].node], 1.5f);
    const auto table = buildLightTable(scene, pose, 10);
    EXPECT_FALSE(table.lights.empty());
    for (const auto& vertex : scene.attributes)
        ASSERT_NEAR(glm::length(vertex.normal), 1, 1e-4f);
    double sum = 0;
    for (const auto& light : table.lights)
        sum += light.pmf;
    EXPECT_NEAR(sum, 1, 1e-4);
}

}  // namespace

TEST_F(Samples, EveryGltfSampleLoadsButForDraco)
{
    const auto files = filesIn(shared_ / "gltf-samples");
    EXPECT_GT(files.size(), 40u);
    for (const auto& file : files) {
        if (file.filename() != "BoxDraco.glb") {
            expectSound(file);
            continue;
        }
        EXPECT_NE(errorOf([&] { loadGltf(file); }).find("KHR_draco_mesh_compression"), std::string::npos);
    }
}

TEST_F(Samples, EveryTestSceneLoadsWithItsTriangles)
{
    // Instanced triangles, from ../shared/scenes/README.md.
    const std::map<std::string, uint64_t> triangles = {
        {"veach_ajar.glb", 382690},        {"veach_ajar_animated.glb", 382690},
        {"veach_ajar_glossy.glb", 382690}, {"veach_ajar_box_light.glb", 382700},
        {"veach_bidir_room.glb", 11544},   {"living_room.glb", 146941},
        {"cornell_box.glb", 36},           {"barcelona_pavilion.glb", 101104},
        {"bistro_exterior.glb", 1094137}};
    for (const auto& file : filesIn(shared_ / "scenes")) {
        expectSound(file);
        const auto expected = triangles.find(file.filename().string());
        if (expected != triangles.end()) {
            EXPECT_EQ(loadGltf(file).instancedTriangleCount(), expected->second) << file;
        }
    }
}

/// The file's tangents were made with MikkTSpace; ours must agree in direction and sign.
TEST_F(Samples, GeneratedTangentsAgreeWithMikkTSpace)
{
    const auto file = shared_ / "gltf-samples" / "NormalTangentMirrorTest.glb";
    const auto given = loadGltf(file);
    auto bytes = readBytes(file);
    const std::string name = "\"TANGENT\"";
    const auto at = std::search(bytes.begin(), bytes.end(), name.begin(), name.end());
    ASSERT_NE(at, bytes.end());
    *(at + 1) = '_';  // an attribute that nobody reads
    writeBytes(scratch() / "without.glb", bytes);
    const auto generated = loadGltf(scratch() / "without.glb");

    ASSERT_EQ(given.triangles.size(), generated.triangles.size());
    double agreement = 0;
    size_t corners = 0, signs = 0;
    for (size_t t = 0; t < given.triangles.size(); ++t)
        for (int i = 0; i < 3; ++i, ++corners) {
            const auto a = given.attributes[given.triangles[t][i]].tangent;
            const auto b = generated.attributes[generated.triangles[t][i]].tangent;
            agreement += glm::dot(glm::vec3(a), glm::vec3(b));
            signs += a.w == b.w;
        }
    RecordProperty("mean_cosine", std::to_string(agreement / double(corners)));
    EXPECT_GT(agreement / double(corners), 0.99);
    EXPECT_GT(double(signs) / double(corners), 0.99);
}
