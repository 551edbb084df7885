// The light table: powers, the parts of textured emitters, the environment's density.
#include "../support/sample_texture.h"
#include "gltf_builder.h"

#include "scene/lights.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

using namespace restirpg;
using nlohmann::json;

namespace {

constexpr double PI = std::numbers::pi;

/// The square with an emissive material, on nodes as given.
GltfBuilder emissiveSquare(const json& material)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["material"] = builder.addMaterial(material);
    return builder;
}

LightTable tableOf(const Scene& scene, float radius = 2)
{
    return buildLightTable(scene, poseNodes(scene, 0), radius);
}

double sumOfPmf(const LightTable& table)
{
    return std::accumulate(table.lights.begin(), table.lights.end(), 0.0,
                           [](double sum, const Light& l) { return sum + l.pmf; });
}

/// A scene lit by an equirectangular texture of one lit texel.
Scene oneTexelSky(uint32_t width, uint32_t height, uint32_t x, uint32_t y)
{
    auto scene = load(squareScene());
    Texture sky;
    sky.width = width;
    sky.height = height;
    sky.wrapV = Texture::Wrap::clampToEdge;
    sky.floats.assign(size_t(width) * height * 4, 0.0f);
    for (size_t c = 0; c < 3; ++c)
        sky.floats[(size_t(y) * width + x) * 4 + c] = 50;
    scene.environment->texture = sky;
    return scene;
}

}  // namespace

TEST(LightTable, TrianglesWeighTheirPower)
{
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}});
    // A second square of four times the area, and one mirrored of the first's.
    builder.addNode({{"mesh", 0}, {"scale", {2, 2, 2}}});
    builder.addNode({{"mesh", 0}, {"scale", {-1, 1, 1}}});
    const auto scene = load(builder);
    const auto table = tableOf(scene);
    ASSERT_EQ(table.lights.size(), 6u);
    EXPECT_NEAR(sumOfPmf(table), 1, 1e-6);
    for (uint32_t i = 0; i < scene.instances.size(); ++i)
        for (uint32_t t = 0; t < 2; ++t) {
            const auto light = table.lightOfTriangle[table.lightMapOfInstance[i] + t];
            EXPECT_EQ(table.lights[light].type, LIGHT_TRIANGLE);
            EXPECT_EQ(table.lights[light].instance, i);
            EXPECT_EQ(table.lights[light].triangle, t);
            EXPECT_NEAR(table.lights[light].pmf, (i == 1 ? 4.0 : 1.0) / 12, 1e-6);
        }
}

TEST(LightTable, EachKindOfLightWeighsItsPowerInWatts)
{
    auto builder = animatedScene();
    builder.json["meshes"][0]["primitives"][0]["material"] =
        builder.addMaterial({{"emissiveFactor", {1, 1, 1}}, {"doubleSided", true}});
    const auto scene = load(builder);
    const double radius = 2, disk = PI * radius * radius;
    const auto table = tableOf(scene, float(radius));
    const auto luminance = [](glm::dvec3 c) { return glm::dot(c, glm::dvec3(0.2126, 0.7152, 0.0722)); };
    // A triangle of the square: area 1/2, two sides. The cubic spline scales the node by (1, 1, 1) at time 0.
    const double triangle = PI * 0.5 * 2, point = 4 * PI * luminance({20, 10, 5}),
                 spot = 2 * PI * (1 - std::cos(0.4)) * 5;
    const double directional = disk * 3, environment = disk * 4 * PI * luminance({0.2, 0.4, 0.6});
    const double sum = 2 * triangle + point + spot + directional + environment;
    ASSERT_EQ(table.lights.size(), 6u);
    const double expected[] = {triangle, point, spot, directional, environment};
    for (const auto& light : table.lights)
        EXPECT_NEAR(light.pmf, expected[light.type] / sum, 1e-6) << light.type;
    EXPECT_EQ(table.lights[table.environmentLight].type, LIGHT_ENVIRONMENT);
    EXPECT_TRUE(table.environmentCells.empty());
}

TEST(LightTable, WhatHasNoPowerIsNeverSelected)
{
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}});
    builder.json["meshes"][0]["primitives"][0]["indices"] =
        builder.addAccessor(std::vector<uint16_t>{0, 1, 2, 0, 0, 1}, UNSIGNED_SHORT, "SCALAR");
    const auto table = tableOf(load(builder));
    ASSERT_EQ(table.lights.size(), 2u) << "a triangle without area may grow";
    EXPECT_EQ(table.lightOfTriangle, (std::vector<uint32_t>{0, 1}));
    EXPECT_EQ(table.lights[0].pmf, 1);
    EXPECT_EQ(table.lights[1].pmf, 0);

    auto dark = load(squareScene());
    dark.environment->radiance = glm::vec3(0);
    EXPECT_TRUE(tableOf(dark).lights.empty());
    EXPECT_EQ(tableOf(dark).environmentLight, INVALID_INDEX);
    EXPECT_EQ(tableOf(dark).lightMapOfInstance, std::vector<uint32_t>{INVALID_INDEX});
}

TEST(LightTable, TexturedEmittersWeighTheirMean)
{
    // The lower left half of the image (under the first triangle, u + v > 1 in file coordinates) is bright.
    std::vector<uint8_t> pixels(32 * 32 * 4, 255);
    for (size_t y = 0; y < 32; ++y)
        for (size_t x = 0; x < 32; ++x)
            for (size_t c = 0; c < 3; ++c)
                pixels[(y * 32 + x) * 4 + c] = y > x ? 255 : 0;
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(32, 32, pixels));
    const auto table = tableOf(load(builder));
    ASSERT_EQ(table.lights.size(), 2u);
    // The diagonal of the square runs from (0, 1) to (1, 0) in uv; y > x holds for half of either triangle.
    EXPECT_NEAR(table.lights[0].pmf, 0.5, 0.05);

    // Bright only left of u = 1/2: 1/4 of the first triangle (v > 1 - u there), 3/4 of the second.
    for (size_t y = 0; y < 32; ++y)
        for (size_t x = 0; x < 32; ++x)
            for (size_t c = 0; c < 3; ++c)
                pixels[(y * 32 + x) * 4 + c] = x < 16 ? 255 : 0;
    builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(32, 32, pixels), {{"wrapS", 33071}, {"wrapT", 33071}});
    EXPECT_NEAR(tableOf(load(builder)).lights[0].pmf, 0.25, 0.02);
}

TEST(LightTable, ASingleBrightTexelIsFound)
{
    std::vector<uint8_t> pixels(32 * 32 * 4, 0);
    pixels[(20 * 32 + 25) * 4] = 255;
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(32, 32, pixels));
    const auto table = tableOf(load(builder));
    ASSERT_EQ(table.lights.size(), 1u);
    EXPECT_EQ(table.lights[0].pmf, 1);
}

/// The part of a triangle, of side^2 (shaders/scene/lights.glsl's emission_part), that barycentrics lie in.
size_t partOf(glm::dvec2 barycentrics, uint32_t side)
{
    const glm::dvec2 place = barycentrics * double(side);
    const uint32_t x = uint32_t(place.x), y = uint32_t(place.y);
    const bool inverted = place.x - x + place.y - y > 1;
    return inverted ? size_t(side - 1 - y) * side + (side - 1 - x) : size_t(y) * side + x;
}

/// Every place that a lookup makes bright can be drawn, whatever the texture's size, place, wrap and filter.
TEST(LightTable, NoBrightPlaceOfATexturedEmitterIsMissed)
{
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(1, 1, std::vector<uint8_t>(4, 255)));
    auto scene = load(builder);
    std::mt19937 random(11);
    std::uniform_real_distribution<float> uniform(-1, 1);
    size_t bright = 0, dark = 0;
    for (int trial = 0; trial < 60; ++trial) {
        auto& texture = scene.textures[0];
        texture.width = 1 + random() % 700;
        texture.height = 1 + random() % 40;
        texture.bytes.assign(size_t(texture.width) * texture.height * 4, 0);
        texture.bytes[4 * (random() % (size_t(texture.width) * texture.height))] = 1;
        texture.wrapU = Texture::Wrap(random() % 3);
        texture.wrapV = Texture::Wrap(random() % 3);
        texture.filter = Texture::Filter(random() % 2);
        for (auto& material : scene.materials) {
            material.emissiveMap.row0 = {3 * uniform(random), uniform(random), 4 * uniform(random)};
            material.emissiveMap.row1 = {uniform(random), 3 * uniform(random), 4 * uniform(random)};
        }
        const auto& map = scene.materials[scene.materialOfTriangle[0]].emissiveMap;
        const auto table = tableOf(scene);
        for (int i = 0; i < 20000; ++i) {
            const uint32_t triangle = random() % 2;
            glm::vec2 b = 0.5f * (1.0f + glm::vec2(uniform(random), uniform(random)));
            b = b.x + b.y > 1 ? 1.0f - b : b;
            glm::vec2 uv(0);
            for (int corner = 0; corner < 3; ++corner) {
                const float weight = corner == 0 ? 1 - b.x - b.y : b[corner - 1];
                uv += weight * scene.attributes[scene.triangles[triangle][corner]].uv0;
            }
            const glm::vec3 point(uv, 1);
            const bool lit = sampleTexture(texture, {glm::dot(map.row0, point), glm::dot(map.row1, point)}).r > 0;
            const uint32_t light =
                table.lightMapOfInstance[0] == INVALID_INDEX ? INVALID_INDEX : table.lightOfTriangle[triangle];
            const float density =
                light == INVALID_INDEX ? 0
                : table.lights[light].cells == INVALID_INDEX
                    ? table.lights[light].pmf
                    : table.emissionCells[table.lights[light].cells + partOf(b, table.lights[light].cellsASide)].pdf;
            ASSERT_TRUE(density > 0 || !lit) << "trial " << trial;
            bright += lit;
            dark += density == 0;
        }
    }
    EXPECT_GT(bright, 1000u);
    EXPECT_GT(dark, 100000u) << "and zero elsewhere, else this test could not fail";
}

TEST(LightTable, PartsOfATexturedEmitterFollowItsTexels)
{
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}, {"emissiveTexture", {{"index", 0}}}});
    builder.addTexture(encodePng(1, 1, std::vector<uint8_t>(4, 255)));
    auto scene = load(builder);
    auto& texture = scene.textures[0];
    texture.width = texture.height = 128;
    texture.bytes.assign(128 * 128 * 4, 0);
    for (size_t y = 0; y < 128; ++y)
        for (size_t x = 0; x < 128; ++x)
            texture.bytes[(y * 128 + x) * 4] = x % 8 == 0 ? 255 : 0;
    const auto table = tableOf(scene);
    ASSERT_EQ(table.lights.size(), 2u);
    EXPECT_NEAR(table.lights[0].pmf, 0.5, 0.01);
    for (const auto& light : table.lights) {
        const std::span cells(table.emissionCells.data() + light.cells, size_t(light.cellsASide) * light.cellsASide);
        double sum = 0, squares = 0;
        for (const auto& cell : cells) {
            sum += cell.pdf;
            squares += double(cell.pdf) * cell.pdf;
        }
        EXPECT_NEAR(sum / double(cells.size()), 1, 1e-4);
        EXPECT_GT(squares / double(cells.size()), 2) << "uniform: 1; a column in 8 lit, with a bilinear filter: 12";
    }
}

TEST(LightTable, APowerIsTheSameHoweverThePoseWasReached)
{
    auto builder = emissiveSquare({{"emissiveFactor", {1, 1, 1}}});
    builder.addNode({{"mesh", 0}, {"scale", {1, 1, 1}}});
    auto scene = load(builder);
    scene.environment->radiance = glm::vec3(0.1f);
    scene.punctualLights.push_back({.node = 0, .type = LIGHT_DIRECTIONAL});
    const auto pose = poseNodes(scene, 0);
    auto grown = pose;
    const auto node = scene.instances[1].node;
    grown[node] = glm::rotate(glm::scale(pose[node], glm::vec3(3, 0.5f, 2)), 1.0f, glm::vec3(1, 2, 3));
    auto nothing = pose;
    nothing[node] = glm::scale(pose[node], glm::vec3(0));
    // From a size of 0, from another size, and back to 0.
    for (const auto& [from, to] : {std::pair(nothing, grown), {pose, grown}, {grown, nothing}}) {
        auto table = buildLightTable(scene, from, 2);
        moveLights(table, scene, to, 5);
        const auto expected = buildLightTable(scene, to, 5);
        ASSERT_EQ(table.lights.size(), expected.lights.size());
        for (size_t i = 0; i < table.lights.size(); ++i) {
            EXPECT_EQ(table.lights[i].pmf, expected.lights[i].pmf) << i;
            EXPECT_EQ(table.lights[i].aliasThreshold, expected.lights[i].aliasThreshold) << i;
            EXPECT_EQ(table.lights[i].alias, expected.lights[i].alias) << i;
        }
        EXPECT_EQ(table.lightOfTriangle, expected.lightOfTriangle) << "indices stand in reservoirs";
    }
    EXPECT_NE(buildLightTable(scene, pose, 2).lights[2].pmf, buildLightTable(scene, grown, 2).lights[2].pmf);
}

TEST(LightTable, RigidMotionLeavesTheTableAlone)
{
    const auto scene = load(emissiveSquare({{"emissiveFactor", {1, 1, 1}}}));
    auto pose = poseNodes(scene, 0);
    auto table = buildLightTable(scene, pose, 2);
    const auto powers = table.powers;
    for (int step = 0; step < 100; ++step) {
        for (auto& matrix : pose)
            matrix = glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0, 0, 1)), 0.1f, glm::vec3(0, 1, 0)) * matrix;
        moveLights(table, scene, pose, 2);
        ASSERT_EQ(table.powers, powers);
    }
}

TEST(LightTable, MovedNodesTakeTheirLightsAlong)
{
    const auto scene = load(animatedScene());
    auto pose = poseNodes(scene, 0);
    auto table = buildLightTable(scene, pose, 2);
    const auto before = table.lights;
    for (auto& matrix : pose)
        matrix = glm::rotate(glm::translate(glm::mat4(1), glm::vec3(0, 0, 10)), float(PI), glm::vec3(0, 1, 0)) * matrix;
    moveLights(table, scene, pose, 2);
    for (size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(table.lights[i].pmf, before[i].pmf);
        if (before[i].type == LIGHT_POINT) {
            EXPECT_LT(glm::length(table.lights[i].position - glm::vec3(-1, 2, 7)), 1e-5f);
        }
        if (before[i].type == LIGHT_DIRECTIONAL) {
            EXPECT_LT(glm::length(table.lights[i].direction - glm::vec3(0, 0, 1)), 1e-5f);
        }
        if (before[i].type == LIGHT_SPOT) {
            EXPECT_LT(glm::length(table.lights[i].direction - glm::vec3(0, 0, -1)), 1e-5f)
                << "it looked along +z before";
        }
    }
}

TEST(EnvironmentTable, TheDensityHasMeanOne)
{
    const auto table = tableOf(oneTexelSky(16, 8, 5, 3));
    double sum = 0;
    for (const auto& cell : table.environmentCells)
        sum += cell.pdf;
    EXPECT_NEAR(sum / (16 * 8), 1, 1e-6);
}

TEST(EnvironmentTable, TheDensityIsPositiveWhereverABilinearLookupIsBright)
{
    for (const auto& [x, y] : {std::pair(5u, 3u), {0u, 0u}, {15u, 7u}, {0u, 4u}}) {
        const auto scene = oneTexelSky(16, 8, x, y);
        const auto table = tableOf(scene);
        int bright = 0, dark = 0;
        for (int i = 0; i < 160; ++i)
            for (int j = 0; j < 80; ++j) {
                const glm::vec2 uv((float(i) + 0.5f) / 160, (float(j) + 0.5f) / 80);
                const float pdf = table.environmentCells[size_t(j / 10) * 16 + size_t(i / 10)].pdf;
                if (sampleTexture(*scene.environment->texture, uv).x > 0) {
                    EXPECT_GT(pdf, 0) << uv.x << " " << uv.y;
                    ++bright;
                }
                dark += pdf == 0;
            }
        EXPECT_GT(bright, 0);
        EXPECT_GT(dark, 0) << "and zero somewhere, else this test could not fail";
    }
}

TEST(EnvironmentTable, AUniformSkyIsSampledBySolidAngle)
{
    auto scene = oneTexelSky(16, 8, 0, 0);
    std::fill(scene.environment->texture->floats.begin(), scene.environment->texture->floats.end(), 1.0f);
    const auto table = tableOf(scene);
    for (size_t y = 0; y < 8; ++y) {
        const double share = 0.5 * (std::cos(PI * double(y) / 8) - std::cos(PI * double(y + 1) / 8));
        EXPECT_NEAR(table.environmentCells[y * 16].pdf, 8 * share, 1e-5) << y;
    }
}
