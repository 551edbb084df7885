// Skins and morph targets in their rest pose, and what is said about the animation that is not shown.
#include "gltf_builder.h"

#include "core/log.h"
#include "scene/gltf.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace restirpg;
using nlohmann::json;

namespace {

/// World position and normal of corner `corner` of an instance's first triangle.
struct Corner {
    glm::vec3 position, normal;
    glm::vec4 tangent;
};

Corner cornerOf(const Scene& scene, size_t instance, int corner)
{
    const auto& placed = scene.instances.at(instance);
    const auto& mesh = scene.meshes[placed.mesh];
    const auto pose = poseNodes(scene, 0)[placed.node];
    const auto vertex = mesh.firstVertex + fromEarliestVertex(scene.triangles[mesh.firstTriangle])[corner];
    const auto& attributes = scene.attributes[vertex];
    return {glm::vec3(pose * glm::vec4(scene.positions[vertex], 1)),
            glm::normalize(glm::transpose(glm::inverse(glm::mat3(pose))) * attributes.normal), attributes.tangent};
}

/// The unit square bound to two joints; `weights` of the second joint, per vertex.
struct SkinnedSquare {
    GltfBuilder builder;
    json primitive;

    explicit SkinnedSquare(const json& joint0, const json& joint1, const std::vector<float>& second = {0, 1, 1, 0})
    {
        primitive = addSquare(builder);
        std::vector<float> weights;
        for (const float w : second)
            weights.insert(weights.end(), {1 - w, w, 0, 0});
        primitive["attributes"]["JOINTS_0"] = builder.addAccessor(
            std::vector<uint8_t>{0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, UNSIGNED_BYTE, "VEC4");
        primitive["attributes"]["WEIGHTS_0"] = builder.addAccessor(weights, FLOAT, "VEC4");
        builder.addNode(joint0);
        builder.addNode(joint1);
        builder.json["skins"] = {{{"joints", {0, 1}}}};
    }

    Scene load(const json& node = json::object())
    {
        auto shown = node;
        shown["mesh"] = builder.addMesh(primitive, "Square");
        shown["skin"] = 0;
        builder.addNode(shown);
        return restirpg::load(builder);
    }
};

}  // namespace

TEST(Skins, VerticesFollowTheirJointsAndNotTheirNode)
{
    SkinnedSquare square({{"translation", {0, 0, 5}}}, {{"translation", {3, 0, 5}}, {"scale", {2, 2, 2}}});
    const auto scene = square.load({{"translation", {100, 0, 0}}});
    expectNear(cornerOf(scene, 0, 0).position, {0, 0, 5});
    expectNear(cornerOf(scene, 0, 1).position, {5, 0, 5});
    expectNear(cornerOf(scene, 0, 2).position, {5, 2, 5});
}

TEST(Skins, InverseBindMatricesAndTheJointsParentsCount)
{
    SkinnedSquare square({{"translation", {1, 0, 0}}}, {{"translation", {1, 0, 0}}});
    auto& nodes = square.builder.json["nodes"];
    square.builder.json["scenes"][0]["nodes"] = json::array();
    square.builder.addNode({{"children", {0, 1}}, {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}}});
    std::vector<float> inverse(32, 0.0f);
    for (size_t i = 0; i < 8; ++i)
        inverse[16 * (i / 4) + 5 * (i % 4)] = 1;
    inverse[12] = inverse[28] = -1;  // translation by -1 along x
    square.builder.json["skins"][0]["inverseBindMatrices"] =
        square.builder.addAccessorJson({{"bufferView", square.builder.addView(inverse.data(), inverse.size() * 4)},
                                        {"componentType", FLOAT},
                                        {"count", 2},
                                        {"type", "MAT4"}});
    ASSERT_EQ(nodes.size(), 3u);
    const auto scene = square.load();
    // The joints' and the bind matrices' shifts cancel: a quarter turn is left.
    expectNear(cornerOf(scene, 0, 1).position, {0, 1, 0});
    expectNear(cornerOf(scene, 0, 2).position, {-1, 1, 0});
}

TEST(Skins, WeightsOfAnyFormatAndSumAreAMean)
{
    const json still = json::object(), moved = {{"translation", {4, 0, 0}}};
    SkinnedSquare half(still, moved, {0.5f, 0.5f, 0.5f, 0.5f});
    expectNear(cornerOf(half.load(), 0, 0).position, {2, 0, 0});
    SkinnedSquare unnormalised(still, moved);
    unnormalised.primitive["attributes"]["WEIGHTS_0"] = unnormalised.builder.addAccessor(
        std::vector<float>{1, 3, 0, 0, 1, 3, 0, 0, 1, 3, 0, 0, 0, 0, 0, 0}, FLOAT, "VEC4");
    const auto scene = unnormalised.load();
    expectNear(cornerOf(scene, 0, 0).position, {3, 0, 0});
    SkinnedSquare bytes(still, moved);
    bytes.primitive["attributes"]["WEIGHTS_0"] = bytes.builder.addAccessor(
        std::vector<uint8_t>{204, 51, 0, 0, 204, 51, 0, 0, 204, 51, 0, 0, 204, 51, 0, 0}, UNSIGNED_BYTE, "VEC4", true);
    expectNear(cornerOf(bytes.load(), 0, 0).position, {0.8f, 0, 0});
    // Eight joints a vertex: a second set of four.
    SkinnedSquare eight(still, moved, {0, 0, 0, 0});
    eight.primitive["attributes"]["JOINTS_1"] = eight.builder.addAccessor(
        std::vector<uint16_t>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, UNSIGNED_SHORT, "VEC4");
    eight.primitive["attributes"]["WEIGHTS_1"] =
        eight.builder.addAccessor(std::vector<float>{1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, FLOAT, "VEC4");
    expectNear(cornerOf(eight.load(), 0, 0).position, {2, 0, 0});
}

TEST(Skins, NormalsTurnWithTheirJointsAndMirroredOnesKeepTheirFront)
{
    const double s = std::sqrt(0.5);
    SkinnedSquare turned({{"rotation", {0, s, 0, s}}}, {{"rotation", {0, s, 0, s}}});
    const auto corner = cornerOf(turned.load(), 0, 0);
    expectNear(corner.normal, {1, 0, 0});
    SkinnedSquare mirrored({{"scale", {-1, 1, 1}}}, {{"scale", {-1, 1, 1}}});
    const auto scene = mirrored.load();
    expectNear(cornerOf(scene, 0, 0).normal, {0, 0, 1});
    const auto a = cornerOf(scene, 0, 0).position, b = cornerOf(scene, 0, 1).position,
               c = cornerOf(scene, 0, 2).position;
    expectNear(glm::normalize(glm::cross(b - a, c - a)), {0, 0, 1});
    // Squeezed along x and tilted: normals go by the inverse transpose.
    SkinnedSquare squeezed({{"scale", {0.5, 1, 1}}, {"rotation", {0, s, 0, s}}}, {{"scale", {0, 1, 1}}});
    EXPECT_TRUE(std::isfinite(cornerOf(squeezed.load(), 0, 0).normal.x));
}

/// The floats beside 100000 are 8 mm apart, and this joint stands between two of them.
TEST(Skins, FarFromTheOriginKeepTheirShape)
{
    const json far = {{"translation", {100000.003, 0, 0}}};
    SkinnedSquare square(far, far);
    const auto scene = square.load();
    for (int corner = 0; corner < 3; ++corner) {
        const auto position = glm::dvec3(cornerOf(scene, 0, corner).position) + glm::dvec3(scene.origin);
        EXPECT_NEAR(position.x, 100000.003 + (corner > 0 ? 1 : 0), 1e-6);
    }
}

TEST(Skins, DamagedOnesAreErrorsOfOneLine)
{
    SkinnedSquare square(json::object(), json::object());
    square.builder.json["skins"][0]["joints"] = {0};
    const auto message = errorOf([&] { square.load(); });
    EXPECT_NE(message.find("mesh 0 'Square' JOINTS_0: vertex 1 has joint 1 of 1"), message.npos) << message;
    SkinnedSquare missing(json::object(), json::object());
    missing.builder.json["skins"][0]["joints"] = {0, 9};
    EXPECT_NE(errorOf([&] { missing.load(); }).find("skins[0].joints[1]"), std::string::npos);
    SkinnedSquare few(json::object(), json::object());
    std::vector<float> one(16, 0.0f);
    few.builder.json["skins"][0]["inverseBindMatrices"] =
        few.builder.addAccessorJson({{"bufferView", few.builder.addView(one.data(), 64)},
                                     {"componentType", FLOAT},
                                     {"count", 1},
                                     {"type", "MAT4"}});
    EXPECT_NE(errorOf([&] { few.load(); }).find("1 matrices for 2 joints"), std::string::npos);
}

namespace {

/// The square with one morph target that moves it by 1 along z and turns its normals to +x.
GltfBuilder morphedSquare(const json& meshWeights, const json& node = json::object())
{
    GltfBuilder builder;
    auto primitive = addSquare(builder);
    std::vector<float> moves, turns;
    for (int i = 0; i < 4; ++i) {
        moves.insert(moves.end(), {0, 0, 1});
        turns.insert(turns.end(), {1, 0, -1});
    }
    primitive["targets"] = {{{"POSITION", builder.addAccessor(moves, FLOAT, "VEC3")},
                             {"NORMAL", builder.addAccessor(turns, FLOAT, "VEC3")}}};
    auto shown = node;
    shown["mesh"] = builder.addMesh(primitive);
    if (!meshWeights.is_null())
        builder.json["meshes"][0]["weights"] = meshWeights;
    builder.addNode(shown);
    return builder;
}

}  // namespace

TEST(Morphs, DefaultWeightsApplyAndTheNodesComeFirst)
{
    expectNear(cornerOf(load(morphedSquare(nullptr)), 0, 0).position, {0, 0, 0});
    const auto full = cornerOf(load(morphedSquare({1.0})), 0, 0);
    expectNear(full.position, {0, 0, 1});
    expectNear(full.normal, {1, 0, 0});
    expectNear(cornerOf(load(morphedSquare({0.25})), 0, 0).position, {0, 0, 0.25f});
    expectNear(cornerOf(load(morphedSquare({-2.0})), 0, 0).position, {0, 0, -2});
    expectNear(cornerOf(load(morphedSquare({1.0}, {{"weights", {3.0}}})), 0, 0).position, {0, 0, 3});
    expectNear(cornerOf(load(morphedSquare({1.0}, {{"weights", {0.0}}})), 0, 0).position, {0, 0, 0});
}

TEST(Morphs, NodesOfOtherWeightsHaveShapesOfTheirOwn)
{
    auto builder = morphedSquare({1.0});
    builder.addNode({{"mesh", 0}, {"weights", {0.5}}});
    builder.addNode({{"mesh", 0}, {"translation", {0, 0, 7}}});
    const auto scene = load(builder);
    EXPECT_EQ(scene.meshes.size(), 2u);
    expectNear(cornerOf(scene, 0, 0).position, {0, 0, 1});
    expectNear(cornerOf(scene, 1, 0).position, {0, 0, 0.5f});
    expectNear(cornerOf(scene, 2, 0).position, {0, 0, 8});
}

/// Colours stay in their range afterwards, and a target of three components leaves alpha.
TEST(Morphs, ColoursAndTextureCoordinatesAreMovedToo)
{
    const auto vertexOf = [](const std::string& type, const std::vector<float>& colour) {
        auto builder = morphedSquare({0.5});
        auto& primitive = builder.json["meshes"][0]["primitives"][0];
        std::vector<float> base, targets, shifts;
        for (int i = 0; i < 4; ++i) {
            base.insert(base.end(), {0.5f, 0.5f, 0.5f, 0.5f});
            targets.insert(targets.end(), colour.begin(), colour.end());
            shifts.insert(shifts.end(), {2, -1});
        }
        primitive["attributes"]["COLOR_0"] = builder.addAccessor(base, FLOAT, "VEC4");
        primitive["targets"][0]["COLOR_0"] = builder.addAccessor(targets, FLOAT, type);
        primitive["targets"][0]["TEXCOORD_0"] = builder.addAccessor(shifts, FLOAT, "VEC2");
        const auto scene = load(builder);
        return scene.attributes[fromEarliestVertex(scene.triangles[0]).x];
    };
    const auto three = vertexOf("VEC3", {0.5f, -4, 4}), four = vertexOf("VEC4", {0.5f, 0, 0, 0.5f});
    EXPECT_EQ(three.color, glm::vec4(0.75f, 0, 1, 0.5f));
    EXPECT_EQ(four.color, glm::vec4(0.75f, 0.5f, 0.5f, 0.75f));
    EXPECT_EQ(three.uv0, glm::vec2(1, 0.5f)) << "the square's first is (0, 1)";
}

TEST(Morphs, OfAnotherCountAreErrors)
{
    auto builder = morphedSquare({1.0});
    builder.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] =
        builder.addAccessor(std::vector<float>{0, 0, 1}, FLOAT, "VEC3");
    EXPECT_NE(errorOf(builder).find("1 elements for 4 positions"), std::string::npos);
    builder.json["meshes"][0]["primitives"][0]["targets"][0]["POSITION"] = 99;
    EXPECT_NE(errorOf(builder).find("targets[0].POSITION"), std::string::npos);
}

TEST(Deformation, IsNamedOnlyWhereAnAnimationAsksForIt)
{
    const auto file = [](const GltfBuilder& builder, const char* name) {
        loadGltf(builder.write(scratch() / name));
        return wasWarned(std::string(name) + ": the animation of skins and morph targets is not shown");
    };
    EXPECT_FALSE(file(morphedSquare({1.0}), "morph_still.glb"));
    auto builder = morphedSquare({1.0});
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int weights = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    builder.json["animations"] = {{{"samplers", {{{"input", times}, {"output", weights}}}},
                                   {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "weights"}}}}}}}};
    EXPECT_TRUE(file(builder, "morph_moves.glb"));

    SkinnedSquare square(json::object(), json::object());
    square.load();
    EXPECT_FALSE(file(square.builder, "skin_still.glb"));
    const int keys = square.builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int moves = square.builder.addAccessor(std::vector<float>{0, 0, 0, 1, 0, 0}, FLOAT, "VEC3");
    square.builder.json["animations"] = {
        {{"samplers", {{{"input", keys}, {"output", moves}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 1}, {"path", "translation"}}}}}}}};
    EXPECT_TRUE(file(square.builder, "skin_moves.glb"));
}
