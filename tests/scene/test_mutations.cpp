// Files damaged at random, of their bytes and of their JSON: each loads or is refused in one line.
#include "gltf_builder.h"

#include "scene/gltf.h"
#include "scene/lights.h"

#include <gtest/gtest.h>

#include <random>

using namespace restirpg;
using nlohmann::json;

namespace {

/// Bits flipped, bytes replaced, ranges removed.
std::vector<uint8_t> mutateBytes(std::vector<uint8_t> bytes, std::mt19937& random)
{
    const auto pick = [&](size_t n) { return size_t(random() % n); };
    const size_t changes = 1 + pick(8);
    for (size_t i = 0; i < changes && bytes.size() > 1; ++i) {
        const size_t at = pick(bytes.size());
        switch (pick(4)) {
        case 0:
            bytes[at] ^= uint8_t(1u << pick(8));
            break;
        case 1:
            bytes[at] = uint8_t(random());
            break;
        case 2:
            bytes.erase(bytes.begin() + long(at), bytes.begin() + long(std::min(bytes.size(), at + 1 + pick(16))));
            break;
        default:
            if (pick(4) == 0)
                bytes.resize(at);
        }
    }
    return bytes;
}

/// All places of a document.
void collect(json& value, std::vector<json*>& places)
{
    places.push_back(&value);
    if (value.is_structured())
        for (auto& element : value)
            collect(element, places);
}

/// A value below the root replaced by an awkward one, removed, or copied from elsewhere.
void mutateJson(json& root, std::mt19937& random)
{
    static const std::vector<json> awkward = {-1,
                                              0,
                                              1,
                                              2,
                                              3,
                                              5120,
                                              5121,
                                              5123,
                                              5125,
                                              5126,
                                              1000000,
                                              2147483647,
                                              2147483648u,
                                              4294967295u,
                                              1e30,
                                              -1e30,
                                              1e300,
                                              1e-30,
                                              0.5,
                                              nullptr,
                                              true,
                                              "",
                                              "x",
                                              "MAT4",
                                              "BLEND",
                                              {1, 2},
                                              {{"a", 1}},
                                              json::array(),
                                              json::object()};
    std::vector<json*> places;
    collect(root, places);
    auto& place = *places[1 + random() % (places.size() - 1)];
    const auto action = random() % 8;
    if (action == 0 && place.is_object() && !place.empty())
        place.erase(std::next(place.begin(), long(random() % place.size())));
    else if (action == 1 && place.is_array() && !place.empty())
        place.erase(place.begin() + long(random() % place.size()));
    else if (action == 2)
        place = json(*places[random() % places.size()]);
    else if (!place.is_structured() || action == 3)
        place = awkward[random() % awkward.size()];
}

/// Load, and use the scene as the renderer does. Either works or raises an Error of one line.
bool survives(const std::filesystem::path& file)
{
    try {
        const auto scene = loadGltf(file);
        const auto pose = poseNodes(scene, 0.5f * scene.duration);
        makeCamera(scene.cameras[0], pose[scene.cameras[0].node], 1.5f);
        buildLightTable(scene, pose, 1);
        for (size_t t = 0; t < scene.triangles.size(); ++t)
            EXPECT_LT(scene.materialOfTriangle[t], scene.materials.size());
        for (const auto& mesh : scene.meshes)
            for (uint32_t t = 0; t < mesh.triangleCount; ++t)
                for (int i = 0; i < 3; ++i)
                    EXPECT_LT(scene.triangles[mesh.firstTriangle + t][i], mesh.vertexCount);
        return true;
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(message.find('\n'), message.npos) << message;
        return false;
    }
}

/// `count` mutants of a builder's file, half of its bytes and half of its JSON. Any other exception or a crash fails.
void mutate(const GltfBuilder& builder, int count, uint32_t seed)
{
    std::mt19937 random(seed);
    const auto original = readBytes(builder.write(scratch() / "original.glb"));
    ASSERT_TRUE(survives(scratch() / "original.glb"));
    int loaded = 0;
    testing::internal::CaptureStderr();
    for (int i = 0; i < count; ++i) {
        const auto file = scratch() / "mutant.glb";
        if (i % 2) {
            writeBytes(file, mutateBytes(original, random));
        } else {
            auto mutant = builder;
            for (uint32_t changes = 1 + random() % 3; changes > 0; --changes)
                mutateJson(mutant.json, random);
            mutant.write(file);
        }
        loaded += survives(file);
    }
    testing::internal::GetCapturedStderr();
    // Both outcomes must be common, or the mutations test nothing.
    EXPECT_GT(loaded, count / 20);
    EXPECT_LT(loaded, count * 19 / 20);
}

}  // namespace

TEST(Mutations, OfGeometryEndInASceneOrAnError)
{
    mutate(geometryScene(), 1000, 1);
}

TEST(Mutations, OfTexturesAndMaterialsEndInASceneOrAnError)
{
    mutate(texturedScene(), 1000, 2);
}

TEST(Mutations, OfNodesLightsAndAnimationEndInASceneOrAnError)
{
    mutate(animatedScene(), 1000, 3);
}
