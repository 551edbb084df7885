// Numbers of the JSON: a value means the same however it is written, and each is read as far as it has a meaning.
#include "gltf_builder.h"

#include "core/log.h"
#include "scene/gltf.h"

#include <gtest/gtest.h>

#include <cmath>

using namespace restirpg;
using nlohmann::json;

namespace {

/// Every number of a document as a double: 4 as 4.0.
void writeAsDoubles(json& value)
{
    if (value.is_number())
        value = value.get<double>();
    else if (value.is_structured())
        for (auto& element : value)
            writeAsDoubles(element);
}

/// The scene, as it is loaded with every integer written as a double.
Scene loadAsDoubles(GltfBuilder builder)
{
    if (!builder.json.contains("buffers")) {
        const auto whole = builder.write(scratch() / "whole.gltf");
        const auto bytes = readBytes(whole);
        builder.json = json::parse(bytes);
    }
    writeAsDoubles(builder.json);
    return loadGltf(builder.write(scratch() / "doubles.gltf"));
}

/// A square of tinted glass, its colour reached after a distance.
GltfBuilder tintedSquare(const json& distance)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial(
        {{"extensions",
          {{"KHR_materials_volume",
            {{"thicknessFactor", 1}, {"attenuationDistance", distance}, {"attenuationColor", {0.5, 0.5, 0.5}}}}}}});
    return builder;
}

}  // namespace

/// As glTF 2.0 has it in section 2.7, and as writers do that know no integers.
TEST(Numbers, IntegersMayBeWrittenAsDoubles)
{
    for (const auto& builder : {geometryScene(), texturedScene(), animatedScene()}) {
        const auto scene = load(builder), doubles = loadAsDoubles(builder);
        EXPECT_EQ(doubles.positions, scene.positions);
        EXPECT_EQ(doubles.triangles, scene.triangles);
        EXPECT_EQ(doubles.textures.size(), scene.textures.size());
        EXPECT_EQ(doubles.channels.size(), scene.channels.size());
        EXPECT_EQ(doubles.punctualLights.size(), scene.punctualLights.size());
        EXPECT_EQ(doubles.bounceCap, scene.bounceCap);
    }
    auto builder = squareScene();
    builder.json["accessors"][0]["count"] = 3.5;
    EXPECT_NE(errorOf(builder).find("accessors[0].count: must be an integer"), std::string::npos);
    builder = squareScene();
    builder.json["nodes"][0]["mesh"] = 0.5;
    EXPECT_NE(errorOf(builder).find("nodes[0].mesh: 0.5 does not point into meshes"), std::string::npos);
}

TEST(Numbers, LargeOnesMayBeWrittenAsIntegers)
{
    for (const json& distance : {json(10000000000), json(1e10)})
        EXPECT_NEAR(load(tintedSquare(distance)).materials[0].absorption.x * 1e10f, std::log(2.0f), 1e-6f) << distance;
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial(
        {{"emissiveFactor", {1, 1, 1}},
         {"extensions", {{"KHR_materials_emissive_strength", {{"emissiveStrength", 3000000000}}}}}});
    EXPECT_EQ(load(builder).materials[0].emission, glm::vec3(3e9f));
    builder = animatedScene();
    for (auto& light : builder.json["extensions"]["KHR_lights_punctual"]["lights"])
        light = {{"type", "point"}, {"intensity", 3000000000}};
    EXPECT_EQ(load(builder).punctualLights[0].intensity, glm::vec3(3e9f));
    // Beyond any integer type.
    EXPECT_EQ(load(tintedSquare(json(18446744073709551615u))).materials[0].flags & MATERIAL_SOLID, MATERIAL_SOLID);
}

/// Exporters write the largest float where the distance is infinite, which is the default.
TEST(Numbers, AnAttenuationDistanceMayBeAsLargeAsItLikes)
{
    const auto absorptionAt = [](double distance, const char* name) {
        return loadGltf(tintedSquare(distance).write(scratch() / name)).materials[0].absorption.x;
    };
    EXPECT_LT(absorptionAt(3.4028234663852886e38, "largest_float.glb"), 1e-37f);
    EXPECT_FALSE(wasWarned("largest_float.glb: material 0"));
    EXPECT_LT(absorptionAt(1e300, "beyond_floats.glb"), 1e-37f);
    EXPECT_TRUE(wasWarned("beyond_floats.glb: material 0: attenuationDistance 1e+300 lies outside"));
}

/// Files may have 4 GiB, and their buffers too. Elements are still counted by tinygltf's int.
TEST(Numbers, BytesAreCountedBeyondTwoGibibytes)
{
    auto builder = squareScene();
    builder.json["buffers"] = {{{"byteLength", 3000000000}}};
    EXPECT_NE(errorOf(builder).find("byteLength is 3000000000"), std::string::npos);
    builder = squareScene();
    builder.json["bufferViews"][0]["byteOffset"] = 3000000000;
    EXPECT_NE(errorOf(builder).find("bufferViews[0]: ends at byte 3000000048"), std::string::npos);
    builder = squareScene();
    builder.json["accessors"][0]["byteOffset"] = 4294967295;
    EXPECT_NE(errorOf(builder).find("accessor 0 needs 4294967343 bytes"), std::string::npos);
    builder = squareScene();
    builder.json["bufferViews"][0]["byteLength"] = 4294967296;
    EXPECT_NE(errorOf(builder).find("bufferViews[0].byteLength: must be an integer from 0 to 4294967295"),
              std::string::npos);
}
