// Nodes, cameras, lights of the file, animation, and what is added when something is missing.
#include "gltf_builder.h"

#include "core/log.h"
#include "image/image.h"
#include "scene/gltf.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace restirpg;
using nlohmann::json;

namespace {

glm::vec3 transform(const glm::mat4& matrix, glm::vec3 point)
{
    return glm::vec3(matrix * glm::vec4(point, 1));
}

/// World matrix of the node that was `gltfIndex` in the file.
glm::mat4 poseOf(const Scene& scene, uint32_t gltfIndex, float time = 0)
{
    const auto pose = poseNodes(scene, time);
    for (size_t i = 0; i < scene.nodes.size(); ++i)
        if (scene.nodes[i].gltfIndex == gltfIndex)
            return pose[i];
    ADD_FAILURE() << "node " << gltfIndex << " is not in the scene";
    return glm::mat4(1);
}

}  // namespace

TEST(Nodes, AChildMovesWithItsParent)
{
    GltfBuilder builder;
    const int mesh = builder.addMesh(addSquare(builder));
    const int child = builder.addNode({{"mesh", mesh}, {"translation", {1, 0, 0}}}, false);
    // A quarter turn about z, scaled by 2, moved up.
    builder.addNode({{"children", {child}},
                     {"rotation", {0, 0, std::sqrt(0.5), std::sqrt(0.5)}},
                     {"scale", {2, 2, 2}},
                     {"translation", {0, 0, 3}}});
    const auto scene = load(builder);
    expectNear(transform(poseOf(scene, uint32_t(child)), {0, 0, 0}), {0, 2, 3});
    expectNear(transform(poseOf(scene, uint32_t(child)), {1, 0, 0}), {0, 4, 3});
    for (size_t i = 0; i < scene.nodes.size(); ++i)
        EXPECT_LT(scene.nodes[i].parent, int(i));
}

TEST(Nodes, PosesOfAFarSceneAreRelativeToItsMiddle)
{
    GltfBuilder builder;
    const int mesh = builder.addMesh(addSquare(builder));
    const int child = builder.addNode({{"mesh", mesh}, {"translation", {0.125, 0.001, 0}}}, false);
    builder.addNode({{"children", {child}}, {"translation", {100000, 0, 100000}}});
    const auto scene = load(builder);
    EXPECT_GT(scene.origin.x, 99999.0f);
    // The floats beside 100000 are 8 mm apart.
    const glm::dvec3 place =
        glm::dvec3(transform(poseOf(scene, uint32_t(child)), {0, 0, 0})) + glm::dvec3(scene.origin);
    EXPECT_NEAR(place.x, 100000.125, 1e-6);
    EXPECT_NEAR(place.y, 0.001, 1e-6);
    EXPECT_EQ(load(squareScene()).origin, glm::vec3(0));
}

/// The file's numbers are doubles, and stay so until the origin is taken off.
TEST(Nodes, FarOnesStandWhereTheFileSays)
{
    const auto placeOf = [](const json& node) {
        GltfBuilder builder;
        auto shown = node;
        shown["mesh"] = builder.addMesh(addSquare(builder));
        builder.addNode(shown);
        const auto scene = load(builder);
        return double(poseOf(scene, 0)[3].x) + double(scene.origin.x);
    };
    EXPECT_NEAR(placeOf({{"translation", {100000.003, 0, 0}}}), 100000.003, 1e-6);
    EXPECT_NEAR(placeOf({{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 100000.003, 0, 0, 1}}}), 100000.003, 1e-6);
}

TEST(Nodes, MatricesAreColumnMajor)
{
    const auto scene = load(animatedScene());
    expectNear(transform(poseOf(scene, 4), {0, 0, 0}), {4, 5, 6});
}

TEST(Nodes, OnlyTheDefaultSceneIsRead)
{
    auto builder = squareScene();
    const int other = builder.addNode({{"mesh", 0}}, false);
    builder.json["scenes"].push_back({{"nodes", {other, other - 1}}});
    EXPECT_EQ(load(builder).instances.size(), 1u);
    builder.json["scene"] = 1;
    EXPECT_EQ(load(builder).instances.size(), 2u);
    builder.json.erase("scene");
    EXPECT_EQ(load(builder).instances.size(), 1u);
    builder.json.erase("scenes");
    EXPECT_EQ(load(builder).instances.size(), 2u) << "without scenes, every root is shown";
}

TEST(Nodes, CyclesAndSecondParentsAreErrors)
{
    auto builder = squareScene();
    builder.json["nodes"][0]["children"] = {0};
    EXPECT_NE(errorOf(builder).find("reached twice"), std::string::npos);
    builder = squareScene();
    builder.addNode({{"children", {0}}, {"name", "second"}});
    EXPECT_NE(errorOf(builder).find("reached twice"), std::string::npos);
}

TEST(Nodes, AHundredThousandLevelsNeedNoStack)
{
    auto builder = squareScene();
    for (int i = 1; i < 100000; ++i)
        builder.addNode({{"children", {i - 1}}}, false);
    builder.json["scenes"][0]["nodes"] = {99999};
    EXPECT_EQ(load(builder).nodes.size(), 100001u) << "and the default camera's";
}

TEST(Nodes, EveryMatrixHasAnInverseAndFlatMeshesStayWhereTheyAre)
{
    const auto turn = glm::mat3(glm::rotate(glm::mat4(1), 0.7f, glm::normalize(glm::vec3(1, 2, 3))));
    const auto scaled = [](float x, float y, float z) {
        return glm::mat3(glm::vec3(x, 0, 0), glm::vec3(0, y, 0), glm::vec3(0, 0, z));
    };
    const std::vector<glm::mat3> matrices = {scaled(2, 2, 0),         scaled(0, 1, 1),
                                             scaled(-3, 0, 1),        scaled(0, 0, 1),
                                             scaled(0, 0, 0),         turn * scaled(1, 0, 1),
                                             scaled(1, 1, 0) * turn,  turn * scaled(0, 0, 5) * turn,
                                             1e-5f * scaled(1, 0, 1), turn * scaled(1e-4f, 1, 1e-4f),
                                             scaled(1e4f, 1e4f, 0),   glm::mat3(1e-7f)};
    for (const auto& matrix : matrices) {
        auto builder = squareScene();
        json columns = json::array();
        for (int column = 0; column < 4; ++column)
            for (int row = 0; row < 4; ++row)
                columns.push_back(row < 3 && column < 3 ? matrix[column][row] : row == column ? 1.0f : 0.0f);
        builder.addNode({{"mesh", 0}, {"matrix", columns}});
        const auto scene = load(builder);
        ASSERT_EQ(scene.instances.size(), 2u);
        const auto pose = glm::mat3(poseNodes(scene, 0)[scene.instances[1].node]);
        const auto product = pose * glm::inverse(pose);
        const float largest = glm::length(matrix[0]) + glm::length(matrix[1]) + glm::length(matrix[2]);
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(product[i][i], 1, 0.1f) << "but for the rounding of the thin direction";
            if (glm::length(pose[i]) > 1e-8f)  // else a speck, where there was a line
                expectNear(pose[i], matrix[i], 2e-5f * largest);
        }
    }
}

TEST(Nodes, AMeshScaledFromNothingIsThereWhenItGrows)
{
    auto builder = squareScene();
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int scales = builder.addAccessor(std::vector<float>{0, 0, 0, 2, 2, 2}, FLOAT, "VEC3");
    builder.json["animations"] = {{{"samplers", {{{"input", times}, {"output", scales}}}},
                                   {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
    const auto scene = load(builder);
    ASSERT_EQ(scene.instances.size(), 1u);
    expectNear(transform(poseOf(scene, 0, 0.5f), {1, 1, 0}), {1, 1, 0});
    EXPECT_GT(glm::length(glm::vec3(poseOf(scene, 0, 0)[0])), 0);
}

TEST(Nodes, OverridesReplaceTheLocalMatrix)
{
    const auto scene = load(animatedScene());
    std::vector<std::optional<glm::mat4>> overrides(scene.nodes.size());
    for (size_t i = 0; i < scene.nodes.size(); ++i)
        if (scene.nodes[i].gltfIndex == 3)
            overrides[i] = glm::translate(glm::mat4(1), glm::vec3(10, 0, 0));
    const auto pose = poseNodes(scene, 0, overrides);
    expectNear(transform(pose[scene.cameras[0].node], {0, 0, 0}), {10.5f, 0.5f, 4});
}

TEST(Animation, StepLinearAndCubicFollowTheSpecification)
{
    const auto scene = load(animatedScene());
    EXPECT_EQ(scene.duration, 3);
    // STEP translation holds (0,0,0) until 1 s, then (1,0,0).
    expectNear(transform(poseOf(scene, 0, 0.99f), {0, 0, 0}), {0, 0, 0});
    expectNear(transform(poseOf(scene, 0, 1.5f), {0, 0, 0}), {1, 0, 0});
    expectNear(transform(poseOf(scene, 0, 99), {0, 0, 0}), {1, 2, 0});
    // LINEAR rotation is a slerp: 45 degrees about z half way to 90.
    const auto turned = glm::mat3(poseOf(scene, 0, 0.5f));
    expectNear(turned * glm::vec3(1, 0, 0), glm::vec3(std::sqrt(0.5f), std::sqrt(0.5f), 0));
    // CUBICSPLINE with zero tangents eases from 1 to 4 in z: at half time the smoothstep's 2.5.
    EXPECT_NEAR(glm::length(poseOf(scene, 0, 2)[2]), 2.5f, 1e-5f);
    EXPECT_NEAR(glm::length(poseOf(scene, 0, 1.5f)[2]), 1 + 3 * (3.0f / 16 - 2.0f / 64), 1e-5f);
}

TEST(Animation, CubicTangentsAreScaledByTheInterval)
{
    auto builder = animatedScene();
    // One key pair 2 s apart, value 0 throughout, out-tangent of the first 3 m/s: Hermite gives 2 * (t^3 - 2 t^2 +
    // t) * 3.
    const int times = builder.addAccessor(std::vector<float>{0, 2}, FLOAT, "SCALAR");
    std::vector<float> values(18, 0.0f);
    values[6] = 3;
    const int output = builder.addAccessor(values, FLOAT, "VEC3");
    builder.json["animations"][0]["samplers"] = {
        {{"input", times}, {"output", output}, {"interpolation", "CUBICSPLINE"}}};
    builder.json["animations"][0]["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}};
    expectNear(transform(poseOf(load(builder), 0, 1), {0, 0, 0}), {2 * 3 * 0.125f, 0, 0});
}

/// Half way between two keys that floats hold, at a place that they do not.
TEST(Animation, FarFromTheOriginDoesNotJumpFromFloatToFloat)
{
    auto builder = squareScene();
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int moves = builder.addAccessor(std::vector<float>{100000, 0, 0, 100000.0078125f, 0, 0}, FLOAT, "VEC3");
    builder.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", moves}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const auto scene = load(builder);
    EXPECT_NEAR(double(poseOf(scene, 0, 0.5f)[3].x) + double(scene.origin.x), 100000.00390625, 1e-6);
}

TEST(Animation, RotationTakesTheShorterWay)
{
    auto builder = animatedScene();
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int turns =
        builder.addAccessor(std::vector<float>{0, 0, 0, 1, 0, 0, -std::sqrt(0.5f), -std::sqrt(0.5f)}, FLOAT, "VEC4");
    builder.json["animations"][0]["samplers"] = {{{"input", times}, {"output", turns}}};
    builder.json["animations"][0]["channels"] = {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "rotation"}}}}};
    expectNear(glm::mat3(poseOf(load(builder), 0, 0.5f)) * glm::vec3(1, 0, 0),
               glm::vec3(std::sqrt(0.5f), std::sqrt(0.5f), 0));
}

TEST(Animation, DamagedKeysAreErrors)
{
    const auto broken = [](const char* place, const json& value) {
        auto builder = animatedScene();
        builder.json["animations"][0][json::json_pointer(place)] = value;
        return errorOf(builder);
    };
    EXPECT_NE(broken("/samplers/0/input", 99).find("accessors"), std::string::npos);
    EXPECT_NE(broken("/samplers/0/interpolation", "BEZIER").find("BEZIER"), std::string::npos);
    EXPECT_NE(broken("/channels/0/sampler", 3).find("sampler 3 of 3"), std::string::npos);
    EXPECT_NE(broken("/channels/0/target/path", "colour").find("colour"), std::string::npos);
    EXPECT_NE(broken("/samplers/2/interpolation", "LINEAR").find("9 values for 3 keys"), std::string::npos);
    auto builder = animatedScene();
    builder.json["animations"][0]["samplers"][0]["input"] =
        builder.addAccessor(std::vector<float>{0, 2, 1}, FLOAT, "SCALAR");
    EXPECT_NE(errorOf(builder).find("ascend"), std::string::npos);
}

TEST(Animation, OfTwoThatMoveTheSameTheLastIsPlayedAndThatIsSaid)
{
    auto builder = squareScene();
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    const int late = builder.addAccessor(std::vector<float>{0, 9}, FLOAT, "SCALAR");
    const auto animation = [&](float x, int input) {
        const int moves = builder.addAccessor(std::vector<float>{x, 0, 0, x, 0, 0}, FLOAT, "VEC3");
        return json{{"samplers", {{{"input", input}, {"output", moves}}}},
                    {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}};
    };
    builder.json["animations"] = {animation(1, late), animation(2, times)};
    const auto scene = loadGltf(builder.write(scratch() / "twice.glb"));
    expectNear(transform(poseOf(scene, 0), {0, 0, 0}), {2, 0, 0});
    EXPECT_EQ(scene.duration, 1) << "the one that is not played does not count";
    const auto said = saidWarnings();
    EXPECT_EQ(std::count_if(said.begin(), said.end(),
                            [](const auto& text) {
                                return text.find(
                                           "twice.glb: node 0: two animations or channels move its translation") !=
                                       text.npos;
                            }),
              1);
}

TEST(Animation, KeysThatOverflowAreAnErrorWhereTheyDo)
{
    auto builder = squareScene();
    const int times = builder.addAccessor(std::vector<float>{0, 1}, FLOAT, "SCALAR");
    std::vector<float> spline(18, 0.0f);
    spline[6] = 3.4e38f;  // the first key's out-tangent
    spline[9] = -3.4e38f;  // the second key's in-tangent
    const int moves = builder.addAccessor(spline, FLOAT, "VEC3");
    builder.json["animations"] = {
        {{"samplers", {{{"input", times}, {"output", moves}, {"interpolation", "CUBICSPLINE"}}}},
         {"channels", {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}}}}}};
    const auto scene = load(builder);
    EXPECT_NE(errorOf([&] { poseNodes(scene, 0.5f); }).find("node 0"), std::string::npos);
    const std::vector<std::optional<glm::mat4>> moved = {glm::scale(glm::mat4(1), glm::vec3(1e15f))};
    const auto message = errorOf([&] { poseNodes(scene, 0, moved); });
    EXPECT_NE(message.find("node 0 '': its matrix reaches"), std::string::npos) << message;
    EXPECT_EQ(message.find("animation"), std::string::npos) << message;
    EXPECT_EQ(poseNodes(scene, NAN).size(), scene.nodes.size()) << "as at time 0";
}

TEST(Cameras, LookAlongTheirNodesMinusZ)
{
    const auto scene = load(animatedScene());
    ASSERT_EQ(scene.cameras.size(), 1u) << "the orthographic one is left out";
    const auto camera = makeCamera(scene.cameras[0], poseNodes(scene, 0)[scene.cameras[0].node], 2);
    expectNear(camera.position, {1.5f, 2.5f, 7});
    expectNear(camera.forward, {0, 0, -1});
    expectNear(camera.up, glm::vec3(0, std::tan(0.4f), 0));
    expectNear(camera.right, glm::vec3(2 * std::tan(0.4f), 0, 0));
}

TEST(Cameras, ScaleAndMirroringDoNotAct)
{
    const CameraNode node{"c", 0, 0.8f};
    const auto camera = makeCamera(node, glm::scale(glm::mat4(1), glm::vec3(-3, 2, 5)), 1);
    expectNear(camera.forward, {0, 0, -1});
    expectNear(camera.right, glm::vec3(std::tan(0.4f), 0, 0));
    EXPECT_NE(errorOf([&] { makeCamera(node, glm::scale(glm::mat4(1), glm::vec3(1, 0, 1)), 1); }).find("singular"),
              std::string::npos);
}

TEST(Cameras, TheDefaultOneFramesTheBoundingSphere)
{
    const auto scene = load(squareScene());
    ASSERT_EQ(scene.cameras.size(), 1u);
    const auto camera = makeCamera(scene.cameras[0], poseNodes(scene, 0)[scene.cameras[0].node], 1);
    // Centre + d r / sin(20 degrees) * 0.9, d = (.35, .25, 1) normalised.
    const auto direction = glm::normalize(glm::vec3(0.35f, 0.25f, 1));
    const float radius = std::sqrt(0.5f);
    expectNear(camera.position, glm::vec3(0.5f, 0.5f, 0) + direction * (radius / std::sin(glm::radians(20.0f)) * 0.9f));
    expectNear(camera.forward, -direction);
    EXPECT_NEAR(glm::length(camera.up), std::tan(glm::radians(20.0f)), 1e-6f);
    EXPECT_NEAR(glm::dot(camera.right, glm::vec3(0, 1, 0)), 0, 1e-6f);
}

TEST(FileLights, ArriveWithTypeColourAndCone)
{
    const auto scene = load(animatedScene());
    ASSERT_EQ(scene.punctualLights.size(), 3u);
    for (const auto& light : scene.punctualLights) {
        if (light.type == LIGHT_POINT)
            expectNear(light.intensity, {20, 10, 5});
        if (light.type == LIGHT_SPOT) {
            EXPECT_FLOAT_EQ(light.innerCone, 0.1f);
            EXPECT_FLOAT_EQ(light.outerCone, 0.4f);
        }
        if (light.type == LIGHT_DIRECTIONAL)
            expectNear(light.intensity, glm::vec3(3));
    }
    auto builder = animatedScene();
    builder.json["extensions"]["KHR_lights_punctual"]["lights"][1]["spot"]["innerConeAngle"] = 0.4;
    EXPECT_NE(errorOf(builder).find("cone angles"), std::string::npos);
    // Below by less than a float can tell.
    builder.json["extensions"]["KHR_lights_punctual"]["lights"][1]["spot"]["innerConeAngle"] = 0.4 - 1e-12;
    EXPECT_EQ(load(builder).punctualLights.size(), 3u);
}

TEST(FileLights, ARangeThatIsIgnoredIsNamedInAWarning)
{
    const auto named = [](const char* file, int light) {
        auto builder = animatedScene();
        builder.json["extensions"]["KHR_lights_punctual"]["lights"][light]["range"] = 4.0;
        loadGltf(builder.write(scratch() / file));
        return wasWarned(std::string(file) + ": the range of lights is ignored");
    };
    EXPECT_TRUE(named("range_of_a_point.glb", 0));
    EXPECT_TRUE(named("range_of_a_spot.glb", 1));
    EXPECT_FALSE(named("range_of_the_sun.glb", 2)) << "it has none";
}

TEST(Environments, ComeFromTheAssetsExtras)
{
    const auto scene = load(animatedScene());
    ASSERT_TRUE(scene.environment);
    expectNear(scene.environment->radiance, {0.2f, 0.4f, 0.6f});
    EXPECT_NEAR(scene.environment->rotation, glm::radians(90.0f), 1e-6f);
    EXPECT_EQ(scene.bounceCap, 6u);
}

TEST(Environments, AFileIsReadAndHashed)
{
    auto builder = squareScene();
    builder.json["asset"]["extras"]["restirpg"] = {{"environment", "sky.exr"}, {"strength", 3}};
    EXPECT_NE(errorOf(builder).find("sky.exr"), std::string::npos);
    Image sky{4, 2, 3, std::vector<float>(24, 1.0f)};
    sky.data[0] = 7;
    sky.data[4] = -1;
    writeExr(scratch() / "sky.exr", {{"", sky}}, PixelType::full);
    const auto scene = load(builder);
    ASSERT_TRUE(scene.environment && scene.environment->texture);
    EXPECT_EQ(scene.environment->radiance, glm::vec3(3));
    EXPECT_EQ(scene.environment->texture->floats[0], 7);
    EXPECT_EQ(scene.environment->texture->floats[5], 0) << "negative radiance is read as 0";
    sky.data[1] = 2;
    writeExr(scratch() / "sky.exr", {{"", sky}}, PixelType::full);
    EXPECT_NE(load(builder).hash, scene.hash);
}

TEST(Environments, AFileOfMoreThanFourGibibytesIsRefusedAsWhatItIs)
{
    auto builder = squareScene();
    builder.json["asset"]["extras"]["restirpg"] = {{"environment", "sky.exr"}};
    writeExr(scratch() / "sky.exr", {{"", {4, 2, 3, std::vector<float>(24, 1.0f)}}}, PixelType::full);
    std::filesystem::resize_file(scratch() / "sky.exr", uint64_t(5) << 30);  // sparse
    EXPECT_EQ(errorOf(builder), (scratch() / "sky.exr").string() + ": larger than 4 GiB; give a smaller file");
    std::filesystem::remove(scratch() / "sky.exr");
}

TEST(Environments, TextIsAConstantOrAnError)
{
    EXPECT_EQ(loadEnvironment("1,2.5,0").radiance, glm::vec3(1, 2.5f, 0));
    for (const char* bad : {"1,2", "1,2,3,4", "1,-2,3", "sky.jpg", "", "nan,1,1", "missing.exr", "missing.hdr"})
        EXPECT_FALSE(errorOf([&] { loadEnvironment(bad); }).empty()) << bad;
}

TEST(Environments, ASceneWithoutLightGetsAWhiteOne)
{
    const auto scene = load(squareScene());
    ASSERT_TRUE(scene.environment);
    EXPECT_EQ(scene.environment->radiance, glm::vec3(1));
    EXPECT_FALSE(load(texturedScene()).environment) << "it has an emissive material";
}

TEST(Environments, ALightThatIsSwitchedOffIsALight)
{
    const auto squareOf = [](const json& extensions) {
        auto builder = squareScene();
        builder.json["materials"] = {{{"emissiveFactor", {1, 1, 1}}, {"extensions", extensions}}};
        builder.json["meshes"][0]["primitives"][0]["material"] = 0;
        return load(builder);
    };
    const auto off = squareOf({{"KHR_materials_emissive_strength", {{"emissiveStrength", 0}}}});
    EXPECT_FALSE(off.environment);
    EXPECT_EQ(off.materials[0].emission, glm::vec3(0));
    EXPECT_TRUE(squareOf({{"KHR_materials_unlit", json::object()}}).environment)
        << "it emits nothing, whatever it says";
}

TEST(Hash, DependsOnEveryByteAndNothingElse)
{
    auto builder = squareScene();
    const auto first = load(builder), second = load(builder);
    EXPECT_EQ(first.hash, second.hash);
    EXPECT_EQ(first.hash.size(), 16u);
    builder.json["nodes"][0]["name"] = "other";
    EXPECT_NE(load(builder).hash, first.hash);
}
