// Materials and textures: each number of the file arrives where the BSDF reads it.
#include "../support/sample_texture.h"
#include "gltf_builder.h"

#include "core/log.h"
#include "scene/fresnel.h"
#include "scene/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

using namespace restirpg;
using nlohmann::json;

namespace {

/// The scene's square with one material.
GltfBuilder withMaterial(const json& material)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial(material);
    return builder;
}

Material materialOf(const json& material)
{
    return load(withMaterial(material)).materials[0];
}

json extensionOf(const std::string& name, const json& value)
{
    return {{"extensions", {{name, value}}}};
}

/// Mean Fresnel reflectance under diffuse light from outside [Walsh 1926, as quoted by Duntley 1942].
double diffuseReflectance(double n)
{
    const double n2 = n * n, n4 = n2 * n2;
    return 0.5 + (n - 1) * (3 * n + 1) / (6 * (n + 1) * (n + 1)) +
           n2 * (n2 - 1) * (n2 - 1) / std::pow(n2 + 1, 3) * std::log((n - 1) / (n + 1)) -
           2 * n * n2 * (n2 + 2 * n - 1) / ((n2 + 1) * (n4 - 1)) +
           8 * n4 * (n4 + 1) / ((n2 + 1) * (n4 - 1) * (n4 - 1)) * std::log(n);
}

}  // namespace

TEST(Materials, DefaultsAreThoseOfTheSpecification)
{
    const auto material = materialOf(json::object());
    EXPECT_EQ(material.baseColor, glm::vec3(1));
    EXPECT_EQ(material.metallic, 1);
    EXPECT_EQ(material.roughness, 1);
    EXPECT_EQ(material.ior, 1.5f);
    EXPECT_EQ(material.specular, 1);
    EXPECT_EQ(material.transmission, 0);
    EXPECT_EQ(material.emission, glm::vec3(0));
    EXPECT_EQ(material.flags, 0u);
    EXPECT_EQ(material.baseColorMap.index, INVALID_INDEX);
}

TEST(Materials, APrimitiveWithoutOneGetsTheDefaultMaterial)
{
    const auto scene = load(squareScene());
    EXPECT_EQ(scene.materials.size(), 1u);
    EXPECT_EQ(scene.materialOfTriangle[0], 0u);
    EXPECT_EQ(scene.materials[0].metallic, 1);
}

TEST(Materials, EveryFactorAndExtensionIsRead)
{
    const auto scene = load(texturedScene());
    const auto& m = scene.materials[0];
    expectNear(m.baseColor, {0.5f, 0.6f, 0.7f});
    EXPECT_FLOAT_EQ(m.alpha, 0.8f);
    EXPECT_FLOAT_EQ(m.metallic, 0.3f);
    EXPECT_FLOAT_EQ(m.roughness, 0.4f);
    EXPECT_FLOAT_EQ(m.normalScale, 0.5f);
    EXPECT_FLOAT_EQ(m.alphaCutoff, 0.4f);
    expectNear(m.emission, {10, 5, 2.5f});
    EXPECT_FLOAT_EQ(m.ior, 1.4f);
    EXPECT_FLOAT_EQ(m.specular, 0.5f);
    expectNear(m.specularColor, {1, 0.9f, 0.8f});
    EXPECT_FLOAT_EQ(m.transmission, 0.5f);
    EXPECT_EQ(m.flags, MATERIAL_DOUBLE_SIDED | MATERIAL_ALPHA_MASK | MATERIAL_SOLID | MATERIAL_EMISSIVE);
    // Beer-Lambert: after the attenuation distance, what is left is the attenuation colour.
    expectNear(glm::exp(-m.absorption * 2.0f), {0.5f, 0.25f, 1});
    for (const auto* map : {&m.baseColorMap, &m.metallicRoughnessMap, &m.normalMap, &m.emissiveMap, &m.transmissionMap,
                            &m.specularMap, &m.specularColorMap})
        EXPECT_LT(map->index, scene.textures.size());
}

TEST(Materials, ColourTexturesAreSrgbAndDataTexturesLinear)
{
    const auto scene = load(texturedScene());
    const auto& m = scene.materials[0];
    const auto srgb = [&](const TextureRef& map) { return scene.textures[map.index].srgb; };
    EXPECT_TRUE(srgb(m.baseColorMap) && srgb(m.emissiveMap) && srgb(m.specularColorMap));
    EXPECT_FALSE(srgb(m.metallicRoughnessMap) || srgb(m.normalMap) || srgb(m.transmissionMap) || srgb(m.specularMap));
    // Two images, each read both ways: four textures, each decoded once.
    EXPECT_EQ(scene.textures.size(), 4u);
}

TEST(Materials, SpecularZeroStaysExactlyZero)
{
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_specular", {{"specularFactor", 0}})).specular, 0);
}

TEST(Materials, UnlitBecomesLambertOfItsColour)
{
    auto material = extensionOf("KHR_materials_unlit", json::object());
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.1, 0.2, 0.3, 1};
    material["emissiveFactor"] = {1, 1, 1};
    const auto m = materialOf(material);
    expectNear(m.baseColor, {0.1f, 0.2f, 0.3f});
    EXPECT_EQ(m.metallic, 0);
    EXPECT_EQ(m.specular, 0);
    EXPECT_EQ(m.emission, glm::vec3(0));
    EXPECT_EQ(m.flags, 0u);
    EXPECT_TRUE(wasWarned("unlit"));
}

TEST(Materials, BlendIsMaskAtOneHalf)
{
    const auto absent =
        materialOf({{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.4}}}}});
    EXPECT_EQ(absent.flags, MATERIAL_ALPHA_MASK);
    EXPECT_EQ(absent.alphaCutoff, 0.5f);
    const auto opaque =
        materialOf({{"alphaMode", "BLEND"}, {"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.6}}}}});
    EXPECT_EQ(opaque.flags, 0u);
    EXPECT_TRUE(wasWarned("BLEND"));
}

TEST(Materials, VolumeWithoutThicknessIsThin)
{
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_volume", {{"thicknessFactor", 0}})).flags, 0u);
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_volume", {{"thicknessFactor", 1}})).flags, MATERIAL_SOLID);
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_volume", {{"thicknessFactor", 1}})).absorption, glm::vec3(0));
}

TEST(Materials, FactorsOutsideTheirRangeAreClampedWithOneWarningAFile)
{
    auto builder =
        withMaterial({{"name", "Wild"},
                      {"pbrMetallicRoughness",
                       {{"baseColorFactor", {5, -1, 0.5, 2}}, {"metallicFactor", 3}, {"roughnessFactor", -1}}},
                      {"emissiveFactor", {2, 0.5, -1}},
                      {"normalTexture", {{"index", 0}, {"scale", 1e30}}},
                      {"alphaMode", "MASK"},
                      {"alphaCutoff", -1},
                      {"extensions",
                       {{"KHR_materials_ior", {{"ior", 1e30}}},
                        {"KHR_materials_emissive_strength", {{"emissiveStrength", 3}}},
                        {"KHR_materials_specular", {{"specularFactor", 9}, {"specularColorFactor", {2, -1, 1}}}},
                        {"KHR_materials_transmission", {{"transmissionFactor", 1.5}}},
                        {"KHR_materials_volume",
                         {{"thicknessFactor", 1}, {"attenuationDistance", 1e-30}, {"attenuationColor", {2, 0, 1}}}}}}});
    builder.addTexture(encodePng(1, 1, {128, 128, 255, 255}));
    const auto scene = loadGltf(builder.write(scratch() / "wild.glb"));
    const auto& m = scene.materials[0];
    EXPECT_EQ(m.baseColor, glm::vec3(1, 0, 0.5f));
    EXPECT_EQ(m.alpha, 1);
    EXPECT_EQ(m.metallic, 1);
    EXPECT_EQ(m.roughness, 0);
    EXPECT_EQ(m.emission, glm::vec3(3, 1.5f, 0));
    EXPECT_EQ(m.alphaCutoff, 0);
    EXPECT_EQ(m.ior, 100);
    EXPECT_EQ(m.specular, 1);
    EXPECT_EQ(m.specularColor, glm::vec3(2, 0, 1)) << "the specification allows more than 1";
    EXPECT_EQ(m.transmission, 1);
    EXPECT_TRUE(std::isfinite(m.absorption.x + m.absorption.y + m.absorption.z));
    EXPECT_GE(m.absorption.x, 0);
    EXPECT_LT(m.normalScale, 1e7f);
    const auto said = saidWarnings();
    EXPECT_EQ(std::count_if(said.begin(), said.end(),
                            [](const auto& text) {
                                return text.find("wild.glb") != text.npos && text.find("clamped") != text.npos;
                            }),
              1);
    EXPECT_TRUE(wasWarned("wild.glb: material 0 'Wild': baseColorFactor 5 lies outside of 0..1"));
}

TEST(Materials, ADarkEmitterKeepsItsTextureForAnEditThatLightsIt)
{
    auto builder = withMaterial({{"emissiveFactor", {0, 0, 0}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(1, 1, {128, 128, 255, 255}));
    const auto scene = loadGltf(builder.write(scratch() / "dark.glb"));
    EXPECT_LT(scene.materials[0].emissiveMap.index, scene.textures.size());
    EXPECT_EQ(scene.materials[0].flags, 0u);
}

TEST(Materials, IorBelowOneIsOneAndZeroIsTotalReflection)
{
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_ior", {{"ior", 0.5}})).ior, 1);
    EXPECT_EQ(materialOf(extensionOf("KHR_materials_ior", {{"ior", -3}})).ior, 1);
    const auto mirror = materialOf(extensionOf("KHR_materials_ior", {{"ior", 0}}));
    EXPECT_EQ(mirror.ior, 0);
    EXPECT_FLOAT_EQ(mirror.coatAverage, 1.0f / 21);
}

TEST(Materials, VertexAlphaAndColourArriveWithinTheirRange)
{
    const auto scene = [](const json& material, auto values, int type, bool normalized, const char* shape) {
        auto builder = withMaterial(material);
        builder.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
            builder.addAccessor(values, type, shape, normalized);
        return loadGltf(builder.write(scratch() / "colours.glb"));
    };
    const json mask = {{"alphaMode", "MASK"}}, blend = {{"alphaMode", "BLEND"}};
    const std::vector<float> faint = {1, 1, 1, 0.2f, 1, 1, 1, 0.2f, 1, 1, 1, 0.2f, 1, 1, 1, 0.2f};
    for (const auto& material : {mask, blend}) {
        const auto masked = scene(material, faint, FLOAT, false, "VEC4");
        EXPECT_EQ(masked.attributes[0].color, glm::vec4(1, 1, 1, 0.2f));
        EXPECT_EQ(masked.materials[0].flags, MATERIAL_ALPHA_MASK);
    }
    EXPECT_EQ(scene(json::object(), faint, FLOAT, false, "VEC4").materials[0].flags, 0u) << "OPAQUE ignores alpha";
    EXPECT_EQ(scene(mask, std::vector<float>(12, 0.5f), FLOAT, false, "VEC3").materials[0].flags, 0u);
    const std::vector<uint8_t> bytes = {255, 0, 51, 0, 255, 0, 51, 0, 255, 0, 51, 0, 255, 0, 51, 0};
    EXPECT_FALSE(wasWarned("colours.glb: vertex colours"));
    const auto red = scene(mask, std::vector<uint16_t>{65535, 0, 13107, 0, 65535, 0, 13107, 0, 65535, 0, 13107, 0},
                           UNSIGNED_SHORT, true, "VEC3");
    expectNear(glm::vec3(red.attributes[0].color), {1, 0, 0.2f});
    EXPECT_EQ(red.attributes[0].color.a, 1);
    expectNear(glm::vec3(scene(mask, bytes, UNSIGNED_BYTE, true, "VEC4").attributes[0].color), {1, 0, 0.2f});
    const auto bright = scene(mask, std::vector<float>{2, 0.5f, -1, 1, 1, 1, 1, 1, 1, 1, 1, 1}, FLOAT, false, "VEC3");
    EXPECT_EQ(bright.attributes[0].color, glm::vec4(1, 0.5f, 0, 1));
    EXPECT_TRUE(wasWarned("colours.glb: vertex colours outside of 0..1"));
}

TEST(Materials, NonsenseIsOneError)
{
    EXPECT_NE(errorOf(withMaterial({{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1}}}}})).find("baseColorFactor"),
              std::string::npos);
}

TEST(Fresnel, CoatAverageMatchesTheClosedFormOfDiffuseReflectance)
{
    for (const double ior : {1.1, 1.33, 1.5, 2.0, 2.42, 10.0}) {
        const double normal = std::pow((ior - 1) / (ior + 1), 2);
        EXPECT_NEAR(fresnelCoatAverage(float(ior)), (diffuseReflectance(ior) - normal) / (1 - normal), 2e-6) << ior;
    }
    EXPECT_EQ(fresnelCoatAverage(1), 0);
    EXPECT_NEAR(fresnelDielectric(1, 1.5f), 0.04f, 1e-7f);
    EXPECT_FLOAT_EQ(fresnelDielectric(0, 1.5f), 1);
}

namespace {

/// Two texels, black and mid-grey (128), in a sampler.
Texture twoTexels(const json& sampler, bool srgb = false)
{
    auto builder = squareScene();
    const int texture = builder.addTexture(encodePng(2, 1, {0, 0, 0, 255, 128, 128, 128, 128}), sampler);
    const json map = {{"index", texture}};
    builder.json["meshes"][0]["primitives"][0]["material"] =
        builder.addMaterial(srgb ? json{{"pbrMetallicRoughness", {{"baseColorTexture", map}}}}
                                 : json{{"pbrMetallicRoughness", {{"metallicRoughnessTexture", map}}}});
    return load(builder).textures[0];
}

constexpr float GREY = 128.0f / 255;

}  // namespace

TEST(Textures, LinearFilteringInterpolatesBetweenTexelCentres)
{
    const auto texture = twoTexels({{"wrapS", 33071}});
    EXPECT_NEAR(sampleTexture(texture, {0.25f, 0.5f}).x, 0, 1e-6f);
    EXPECT_NEAR(sampleTexture(texture, {0.5f, 0.5f}).x, GREY / 2, 1e-6f);
    EXPECT_NEAR(sampleTexture(texture, {0.75f, 0.5f}).x, GREY, 1e-6f);
}

TEST(Textures, SrgbIsDecodedBeforeFilteringAndAlphaNever)
{
    const auto texture = twoTexels({{"wrapS", 33071}}, true);
    EXPECT_NEAR(sampleTexture(texture, {0.75f, 0.5f}).x, 0.2158605f, 1e-6f);
    EXPECT_NEAR(sampleTexture(texture, {0.5f, 0.5f}).x, 0.2158605f / 2, 1e-6f);
    EXPECT_NEAR(sampleTexture(texture, {0.75f, 0.5f}).w, GREY, 1e-6f);
}

TEST(Textures, WrapModesContinueTheImageAsNamed)
{
    const auto at = [](int wrap, float u) {
        return sampleTexture(twoTexels({{"wrapS", wrap}, {"magFilter", 9728}}), {u, 0.5f}).x;
    };
    constexpr int REPEAT = 10497, CLAMP = 33071, MIRROR = 33648;
    EXPECT_EQ(at(REPEAT, 1.25f), 0);
    EXPECT_FLOAT_EQ(at(REPEAT, -0.25f), GREY);
    EXPECT_FLOAT_EQ(at(CLAMP, 1.25f), GREY);
    EXPECT_EQ(at(CLAMP, -3), 0);
    EXPECT_FLOAT_EQ(at(MIRROR, 1.25f), GREY);
    EXPECT_EQ(at(MIRROR, 1.75f), 0);
    EXPECT_EQ(at(MIRROR, -0.25f), 0);
    EXPECT_FLOAT_EQ(at(MIRROR, -0.75f), GREY);
    EXPECT_TRUE(std::isfinite(at(REPEAT, 1e30f)));
}

TEST(Textures, SixteenBitImagesKeepTheirPrecision)
{
    // 1 x 1, RGB16: 65535, 32768, 1.
    const std::string png = "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABEAIAAADA54+dAAAAD0lEQVR42mP4/"
                            "7+BgYERAAz9AoA1Gq+qAAAAAElFTkSuQmCC";
    auto builder = squareScene();
    builder.json["images"] = {{{"uri", png}}};
    builder.json["textures"] = {{{"source", 0}}};
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial({{"normalTexture", {{"index", 0}}}});
    const auto scene = load(builder);
    expectNear(sampleTexture(scene.textures[0], {0, 0}), {1, 32768.0f / 65535, 1.0f / 65535}, 1e-7f);
}

TEST(Textures, CmykJpegsAreTheLightThatTheirInksLetThrough)
{
    // 8 x 8, stored values 200, 100, 50, 220. With Adobe's marker these are 255 minus the ink.
    const std::string jpeg =
        "/9j/7gAOQWRvYmUAZAAAAAAA/9sAQwACAQEBAQECAQEBAgICAgIEAwICAgIFBAQDBAYFBgYGBQYGBgcJCAYHCQcGBggLCAkKCgoKCgYICwwL"
        "CgwJCgoK/8AAFAgACAAIBEMRAE0RAFkRAEsRAP/EAB8AAAEFAQEBAQEBAAAAAAAAAAABAgMEBQYHCAkKC//EALUQAAIBAwMCBAMFBQQEAAAB"
        "fQECAwAEEQUSITFBBhNRYQcicRQygZGhCCNCscEVUtHwJDNicoIJChYXGBkaJSYnKCkqNDU2Nzg5OkNERUZHSElKU1RVVldYWVpjZGVmZ2hp"
        "anN0dXZ3eHl6g4SFhoeIiYqSk5SVlpeYmZqio6Slpqeoqaqys7S1tre4ubrCw8TFxsfIycrS09TV1tfY2drh4uPk5ebn6Onq8fLz9PX29/j5"
        "+v/aAA4EQwBNAFkASwAAPwD9IK8Pr8x6/XCv/9k=";
    // Without: the marker, 16 bytes behind the first two, goes; base64 of 18 bytes is 24 characters.
    for (const auto& [text, expected] : {std::pair(jpeg, glm::vec3(200 * 220, 100 * 220, 50 * 220)),
                                         std::pair("/9j/" + jpeg.substr(24), glm::vec3(55 * 35, 155 * 35, 205 * 35))}) {
        auto builder = withMaterial({{"normalTexture", {{"index", 0}}}});
        builder.json["images"] = {{{"uri", "data:image/png;base64," + text}}};
        builder.json["textures"] = {{{"source", 0}}};
        expectNear(glm::vec3(sampleTexture(load(builder).textures[0], {0.5f, 0.5f})), expected / (255.0f * 255),
                   0.012f);
    }
}

TEST(Textures, OtherFormatsAreNamed)
{
    for (const auto& [bytes, name] : {std::pair(std::string("RIFF\x10\0\0\0WEBPVP8 ", 16), "WebP"),
                                      std::pair(std::string("GIF89a0123456789"), "GIF")}) {
        auto builder = withMaterial({{"normalTexture", {{"index", 0}}}});
        builder.addTexture({bytes.begin(), bytes.end()});
        const auto message = errorOf(builder);
        EXPECT_NE(message.find(fmt::format("image 0: is {}, not a PNG or JPEG", name)), message.npos) << message;
    }
}

TEST(Textures, TransformIsTranslationTimesRotationTimesScale)
{
    const auto map = load(texturedScene()).materials[0].baseColorMap;
    const float c = std::cos(0.5f), s = std::sin(0.5f);
    // (1, 0) scaled to (2, 0), turned to 2 (c, -s): v runs downward, so that the image turns clockwise.
    expectNear(glm::vec3(glm::dot(map.row0, glm::vec3(1, 0, 1)), glm::dot(map.row1, glm::vec3(1, 0, 1)), 0),
               {2 * c + 0.1f, -2 * s + 0.2f, 0});
    expectNear(glm::vec3(glm::dot(map.row0, glm::vec3(0, 1, 1)), glm::dot(map.row1, glm::vec3(0, 1, 1)), 0),
               {3 * s + 0.1f, 3 * c + 0.2f, 0});
}

TEST(Textures, TheTransformsTexCoordOverridesTheTextureInfos)
{
    auto builder = texturedScene();
    auto& map = builder.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    map["texCoord"] = 0;
    map["extensions"]["KHR_texture_transform"]["texCoord"] = 1;
    builder.json["materials"][0]["normalTexture"]["texCoord"] = 1;
    builder.json["materials"][0]["emissiveTexture"]["texCoord"] = 5;
    const auto scene = load(builder);
    EXPECT_EQ(scene.materials[0].baseColorMap.uvSet, 1u);
    EXPECT_EQ(scene.materials[0].normalMap.uvSet, 1u);
    EXPECT_EQ(scene.materials[0].emissiveMap.uvSet, 0u);
    EXPECT_TRUE(wasWarned("TEXCOORD_5"));
}

TEST(Textures, AMissingImageThatNoMaterialShowsDoesNoHarm)
{
    auto builder = squareScene();
    const auto hash = load(builder).hash;
    builder.json["images"] = {{{"uri", "nowhere.png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    const auto scene = load(builder);
    EXPECT_TRUE(scene.textures.empty());
    EXPECT_EQ(scene.files.size(), 1u) << "only what was read";
    EXPECT_NE(scene.hash, hash);
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial({{"normalTexture", {{"index", 0}}}});
    EXPECT_NE(errorOf(builder).find("images[0]: 'nowhere.png': no such file; put it beside the scene"),
              std::string::npos)
        << errorOf(builder);
}

TEST(Textures, ExternalFilesAreFoundBesideTheSceneAndNamedWhenMissing)
{
    auto builder = squareScene();
    builder.json["images"] = {{{"uri", "a%20picture.png"}}};
    builder.json["textures"] = {{{"source", 0}}};
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial({{"normalTexture", {{"index", 0}}}});
    EXPECT_NE(errorOf(builder).find("a%20picture.png"), std::string::npos);
    writeBytes(scratch() / "a picture.png", encodePng(3, 5, std::vector<uint8_t>(60, 255)));
    const auto scene = load(builder);
    EXPECT_EQ(scene.textures[0].width, 3u);
    EXPECT_EQ(scene.textures[0].height, 5u);
    writeBytes(scratch() / "a picture.png", encodePng(5, 3, std::vector<uint8_t>(60, 255)));
    EXPECT_NE(load(builder).hash, scene.hash) << "the hash covers external files";
}
