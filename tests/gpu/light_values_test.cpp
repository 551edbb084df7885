// The values of lights against closed forms on the host.
#include "../support/sample_texture.h"
#include "gpu_test.h"
#include "light_case.h"
#include "light_scenes.h"

#include <cmath>
#include <random>

namespace restirpg::test {
namespace {

constexpr double PI = 3.14159265358979;

std::vector<LightValues> evaluate(const UploadedScene& scene, const std::vector<LightQuery>& queries)
{
    std::vector<LightQuery> padded = queries;
    padded.resize((queries.size() + 63) / 64 * 64, queries.back());
    const Buffer inputs = device().createBuffer(padded, "queries");
    const Buffer results = device().createBuffer(padded.size() * sizeof(LightValues), "values");
    LightCase test{};
    test.frame = scene.frame.address();
    test.inputs = inputs.address();
    test.results = results.address();
    run("light_values", test, uint32_t(padded.size()), &scene.gpu.bindings());
    return device().download<LightValues>(results, queries.size());
}

/// Directions all over the sphere, each with a point x.
std::vector<LightQuery> randomQueries(uint32_t light)
{
    std::mt19937 generator(3);
    std::normal_distribution<float> normal;
    std::vector<LightQuery> queries(512);
    for (LightQuery& query : queries) {
        const auto draw = [&] { return glm::vec3(normal(generator), normal(generator), normal(generator)); };
        query.x = draw();
        query.light = light;
        query.barycentrics = {0.2f, 0.3f};
        query.direction = glm::normalize(draw());
    }
    return queries;
}

/// Index of the scene's first light of a type.
uint32_t lightOfType(const UploadedScene& scene, uint32_t type)
{
    const auto& lights = scene.gpu.lights().lights;
    for (uint32_t index = 0; index < lights.size(); ++index)
        if (lights[index].type == type)
            return index;
    throw std::logic_error("no light of that type");
}

TEST(LightValues, PointAndSpotFallOffWithTheSquaredDistanceAndTheCone)
{
    Scene source = darkScene();
    addPunctualLights(source);
    const UploadedScene scene(source);
    for (const uint32_t type : {LIGHT_POINT, LIGHT_SPOT}) {
        const uint32_t index = lightOfType(scene, type);
        const Light& light = scene.gpu.lights().lights[index];
        const auto queries = randomQueries(index);
        const auto values = evaluate(scene, queries);
        for (size_t k = 0; k < queries.size(); ++k) {
            const glm::dvec3 d = glm::dvec3(light.position) - glm::dvec3(queries[k].x);
            const double cosine = glm::dot(-glm::normalize(d), glm::dvec3(light.direction));
            double cone = 1;
            if (type == LIGHT_SPOT) {
                const double inner = std::cos(20 * PI / 180), outer = std::cos(45 * PI / 180);
                cone = std::pow(std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0), 2);
            }
            const glm::dvec3 expected = glm::dvec3(1, 2, 3) * cone / glm::dot(d, d);
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(values[k].radiance[channel], expected[channel], 1e-4 * expected[channel] + 1e-6);
            ASSERT_NEAR(values[k].distance, glm::length(d), 1e-5 * glm::length(d));
            ASSERT_EQ(values[k].pdf, light.pmf);
        }
    }
}

TEST(LightValues, ADirectionalLightIsTheSameEverywhere)
{
    Scene source = darkScene();
    addPunctualLights(source);
    const UploadedScene scene(source);
    const uint32_t index = lightOfType(scene, LIGHT_DIRECTIONAL);
    const glm::vec3 towards = -scene.gpu.lights().lights[index].direction;
    for (const LightValues& value : evaluate(scene, randomQueries(index))) {
        ASSERT_EQ(value.radiance, glm::vec3(1, 2, 3));
        ASSERT_LT(glm::distance(value.wi, towards), 1e-6f);
        ASSERT_GT(value.distance, 1e29f);
    }
}

TEST(LightValues, OneSidedTrianglesEmitFromTheirFrontOnlyInMirroredInstancesToo)
{
    const UploadedScene scene(triangleLightScene());
    const auto& lights = scene.gpu.lights().lights;
    for (uint32_t index = 0; index < lights.size(); ++index) {
        if (lights[index].triangle > 1)
            continue;
        const bool oneSided = lights[index].triangle == 0;
        const glm::mat4 pose = *scene.scene.nodes[scene.scene.instances[lights[index].instance].node].matrix;
        std::array<glm::dvec3, 3> p;
        for (uint32_t corner = 0; corner < 3; ++corner)
            p[corner] = glm::dvec3(pose * glm::vec4(scene.scene.positions[3 * lights[index].triangle + corner], 1));
        // glTF: the front is counter-clockwise, and a mirroring node reverses the winding.
        const glm::dvec3 cross =
            glm::cross(p[1] - p[0], p[2] - p[0]) * (glm::determinant(glm::mat3(pose)) < 0 ? -1.0 : 1.0);
        const auto queries = randomQueries(index);
        const auto values = evaluate(scene, queries);
        for (size_t k = 0; k < queries.size(); ++k) {
            const glm::dvec3 y = p[0] * 0.5 + p[1] * 0.2 + p[2] * 0.3;
            const glm::dvec3 d = y - glm::dvec3(queries[k].x);
            const bool front = glm::dot(cross, d) < 0;
            const glm::vec3 emission = oneSided ? glm::vec3(1, 2, 3) : glm::vec3(4, 1, 1);
            ASSERT_EQ(values[k].radiance, front || !oneSided ? emission : glm::vec3(0)) << "light " << index;
            const double area = 0.5 * glm::length(cross),
                         cosine = std::abs(glm::dot(glm::normalize(cross), glm::normalize(d)));
            const double pdf = lights[index].pmf * glm::dot(d, d) / (area * cosine);
            ASSERT_NEAR(values[k].pdf, pdf, 1e-3 * pdf) << "light " << index;
        }
    }
}

TEST(LightValues, TexturesColourEmissionAndMasksRemoveIt)
{
    const UploadedScene scene(triangleLightScene());
    const auto& lights = scene.gpu.lights().lights;
    for (uint32_t index = 0; index < lights.size(); ++index) {
        if (lights[index].triangle != 2 && lights[index].triangle != 3)
            continue;
        auto queries = randomQueries(index);
        std::mt19937 generator(9);
        std::uniform_real_distribution<float> uniform;
        for (LightQuery& query : queries) {
            const float r = std::sqrt(uniform(generator));
            query.barycentrics = {1 - r, uniform(generator) * r};
        }
        const auto values = evaluate(scene, queries);
        for (size_t k = 0; k < queries.size(); ++k) {
            const glm::vec2 b = queries[k].barycentrics;
            const glm::vec2 uv =
                glm::vec2(0.1f) * (1 - b.x - b.y) + glm::vec2(0.9f, 0.2f) * b.x + glm::vec2(0.3f, 0.8f) * b.y;
            const glm::vec4 texel = sampleTexture(scene.scene.textures[0], uv);
            if (std::abs(texel.a - 0.5f) < 1e-4f)
                continue;  // too close to the cutoff for rounding
            const glm::vec3 expected = lights[index].triangle == 2 ? glm::vec3(8, 2, 4) * glm::vec3(texel)
                                                                   : (texel.a >= 0.5f ? glm::vec3(5) : glm::vec3(0));
            ASSERT_LT(glm::distance(values[k].radiance, expected), 1e-4f) << "light " << index;
        }
    }
}

TEST(LightValues, TheEnvironmentIsLookedUpByLongitudeAndLatitude)
{
    Scene source = darkScene();
    addPunctualLights(source);
    source.environment = sunnySky();
    const UploadedScene scene(source);
    const auto queries = randomQueries(0);
    const auto values = evaluate(scene, queries);
    const double c = std::cos(0.7), s = std::sin(0.7);
    for (size_t k = 0; k < queries.size(); ++k) {
        const glm::dvec3 w(queries[k].direction);
        // The sky is turned by +0.7 about y, so the direction is turned back.
        const glm::dvec3 d(c * w.x - s * w.z, w.y, s * w.x + c * w.z);
        const double u = 0.5 + std::atan2(d.x, -d.z) / (2 * PI), v = std::acos(d.y) / PI;
        ASSERT_NEAR(values[k].uv.x, u, 1e-5);
        ASSERT_NEAR(values[k].uv.y, v, 1e-5);
        ASSERT_LT(glm::distance(values[k].roundTrip, queries[k].direction), 1e-4f);
        const glm::vec3 expected =
            glm::vec3(1, 0.9f, 0.8f) * glm::vec3(sampleTexture(*source.environment->texture, glm::vec2(u, v)));
        ASSERT_LT(glm::distance(values[k].environment, expected), 1e-3f + 1e-3f * expected.x);
    }
}

}  // namespace
}  // namespace restirpg::test
