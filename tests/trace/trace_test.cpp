// Both tracing back ends against Embree, ray by ray. Needs no shared scene: three meshes made here, instanced,
// mirrored, scaled.
#include "trace/devices.h"
#include "trace/rays.h"

#include "gpu/bvh.h"
#include "scene/gltf.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <random>

namespace restirpg::test {
namespace {

/// A scene of several random triangle clouds and a tessellated sphere, each placed by its own nodes; one mesh is
/// shared.
Scene randomScene()
{
    Scene scene;
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> uniform(-1, 1);
    const auto point = [&] { return glm::vec3(uniform(generator), uniform(generator), uniform(generator)); };
    const auto addMesh = [&](const std::vector<std::array<glm::vec3, 3>>& triangles) {
        SceneMesh mesh;
        mesh.firstVertex = uint32_t(scene.positions.size());
        mesh.firstTriangle = uint32_t(scene.triangles.size());
        for (const auto& triangle : triangles) {
            const uint32_t first = uint32_t(scene.positions.size()) - mesh.firstVertex;
            scene.positions.insert(scene.positions.end(), triangle.begin(), triangle.end());
            scene.triangles.push_back({first, first + 1, first + 2});
        }
        mesh.vertexCount = uint32_t(scene.positions.size()) - mesh.firstVertex;
        mesh.triangleCount = uint32_t(scene.triangles.size()) - mesh.firstTriangle;
        scene.meshes.push_back(mesh);
    };
    std::vector<std::array<glm::vec3, 3>> cloud, large, sphere;
    for (int i = 0; i < 4000; ++i) {
        const glm::vec3 center = 2.0f * point();
        cloud.push_back({center, center + 0.1f * point(), center + 0.1f * point()});
    }
    for (int i = 0; i < 12; ++i)  // long and thin, across everything: the case for spatial splits
        large.push_back({8.0f * point(), 8.0f * point(), 8.0f * point()});
    constexpr int RINGS = 48;
    const auto onSphere = [](int i, int j) {
        const float theta = 3.14159265f * float(i) / RINGS, phi = 6.2831853f * float(j) / RINGS;
        return glm::vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    };
    for (int i = 0; i < RINGS; ++i)
        for (int j = 0; j < RINGS; ++j) {
            sphere.push_back({onSphere(i, j), onSphere(i + 1, j), onSphere(i + 1, j + 1)});
            sphere.push_back({onSphere(i, j), onSphere(i + 1, j + 1), onSphere(i, j + 1)});
        }
    addMesh(cloud);
    addMesh(large);
    addMesh(sphere);
    scene.attributes.resize(scene.positions.size());
    scene.materials.emplace_back();
    scene.materialOfTriangle.resize(scene.triangles.size());

    const auto place = [&](uint32_t mesh, const glm::mat4& matrix) {
        Node node;
        node.name = "node" + std::to_string(scene.nodes.size());
        node.matrix = matrix;
        scene.nodes.push_back(node);
        scene.instances.push_back({mesh, uint32_t(scene.nodes.size() - 1)});
    };
    place(0, glm::mat4(1));
    place(1, glm::rotate(glm::mat4(1), 0.7f, glm::vec3(1, 2, 3)));
    place(2, glm::translate(glm::mat4(1), glm::vec3(2, 0, -1)));
    place(2, glm::scale(glm::translate(glm::mat4(1), glm::vec3(-3, 1, 0)), glm::vec3(-0.5f, 2, 1)));  // mirrored
    place(2, glm::scale(glm::rotate(glm::mat4(1), 1.0f, glm::vec3(0, 1, 0)), glm::vec3(0.05f)));
    return scene;
}

/// A square at y = 0.
Scene floorOf(float half)
{
    Scene scene;
    scene.positions = {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
    scene.triangles = {{0, 1, 2}, {0, 2, 3}};
    SceneMesh mesh;
    mesh.vertexCount = 4;
    mesh.triangleCount = 2;
    scene.meshes = {mesh};
    scene.attributes.resize(scene.positions.size());
    scene.materials.emplace_back();
    scene.materialOfTriangle.resize(scene.triangles.size());
    scene.nodes.emplace_back();
    scene.instances.push_back({0, 0});
    return scene;
}

std::vector<Ray> randomRays(size_t count, float length)
{
    std::mt19937 generator(11);
    std::uniform_real_distribution<float> uniform(-4, 4);
    const auto point = [&] { return glm::vec3(uniform(generator), uniform(generator), uniform(generator)); };
    std::vector<Ray> rays;
    for (size_t i = 0; i < count; ++i)
        rays.push_back({point(), point(), length});
    for (int axis = 0; axis < 3; ++axis)  // directions with exact zeros
        for (int i = 0; i < 200; ++i) {
            glm::vec3 direction(0);
            direction[axis] = i % 2 ? 1.0f : -1.0f;
            rays.push_back({point(), direction, 1e30f});
        }
    return rays;
}

/// Share of rays whose hits differ: other triangle at another distance (two surfaces at one distance are one hit), or
/// other distance.
double disagreement(const std::vector<TracedHit>& a, const std::vector<TracedHit>& b)
{
    size_t different = 0;
    for (size_t i = 0; i < a.size(); ++i) {
        const bool bothMiss = a[i].hit.instance == INVALID_INDEX && b[i].hit.instance == INVALID_INDEX;
        const bool oneMisses = (a[i].hit.instance == INVALID_INDEX) != (b[i].hit.instance == INVALID_INDEX);
        different += !bothMiss && (oneMisses || std::abs(a[i].t - b[i].t) > 1e-4f * std::max(1.0f, a[i].t));
    }
    return double(different) / double(a.size());
}

class TraceTest : public testing::TestWithParam<const char*> {};

TEST_P(TraceTest, ClosestHitsAreEmbreesInAtLeast9999Of10000Rays)
{
    const Scene scene = randomScene();
    const auto pose = poseNodes(scene, 0);
    const EmbreeScene embree(scene, pose);
    DeviceTracer tracer(deviceOf(GetParam()), scene, pose);
    const auto rays = randomRays(100000, 1e30f);
    const auto expected = embree.closest(rays), hits = tracer.closest(rays);
    EXPECT_LE(disagreement(hits, expected), 1e-4);
    size_t sameTriangle = 0, found = 0;
    for (size_t i = 0; i < rays.size(); ++i)
        if (expected[i].hit.instance != INVALID_INDEX) {
            ++found;
            sameTriangle += hits[i].hit.instance == expected[i].hit.instance &&
                            hits[i].hit.triangle == expected[i].hit.triangle &&
                            glm::distance(hits[i].hit.barycentrics, expected[i].hit.barycentrics) < 1e-2f;
        }
    EXPECT_GT(found, rays.size() / 4) << "the rays must hit something for this test to mean anything";
    EXPECT_GE(double(sameTriangle), 0.999 * double(found));
}

/// A ball of small triangles, near and far: rays through it meet its front, also where they pass an edge.
TEST(SoftwareTrace, NoRayPassesBetweenTrianglesOfAClosedMesh)
{
    constexpr uint32_t RINGS = 64;
    Scene scene = floorOf(1);
    scene.positions.clear();
    scene.triangles.clear();
    for (uint32_t i = 0; i <= RINGS; ++i)
        for (uint32_t j = 0; j < RINGS; ++j) {
            const float theta = 3.14159265f * float(i) / RINGS, phi = 6.2831853f * float(j) / RINGS;
            scene.positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta),
                                         std::sin(theta) * std::sin(phi));
        }
    for (uint32_t i = 0; i < RINGS; ++i)
        for (uint32_t j = 0; j < RINGS; ++j) {
            const uint32_t a = i * RINGS + j, b = i * RINGS + (j + 1) % RINGS, c = a + RINGS, d = b + RINGS;
            scene.triangles.emplace_back(a, c, d);
            scene.triangles.emplace_back(d, b, a);
        }
    scene.meshes[0].vertexCount = uint32_t(scene.positions.size());
    scene.meshes[0].triangleCount = uint32_t(scene.triangles.size());
    scene.attributes.resize(scene.positions.size());
    scene.materialOfTriangle.assign(scene.triangles.size(), 0);
    DeviceTracer tracer(deviceOf("software"), scene, poseNodes(scene, 0));
    for (const bool moved : {false, true}) {
        if (moved)  // an object with a hierarchy of its own
            tracer.move(poseNodes(scene, 0, {glm::rotate(glm::mat4(1), 0.4f, glm::vec3(1, 2, 3))}));
        for (const float distance : {0.0f, 5.0f, 100.0f, 3000.0f}) {
            std::vector<Ray> rays;
            for (const Ray& ray : randomRays(50000, 1e30f)) {
                const glm::vec3 from = distance * glm::normalize(ray.origin), to = 0.1f * ray.direction;
                rays.push_back({from, glm::normalize(distance > 0 ? to - from : to), std::max(distance, 1.5f)});
            }
            const auto hits = tracer.closest(rays);
            const auto passed = std::count_if(hits.begin(), hits.end(),
                                              [](const auto& hit) { return hit.hit.instance == INVALID_INDEX; });
            EXPECT_EQ(passed, 0) << "of " << rays.size() << " rays from " << distance << " m"
                                 << (moved ? ", moved" : "");
        }
    }
}

TEST_P(TraceTest, AnyHitAgreesWithEmbree)
{
    const Scene scene = randomScene();
    const auto pose = poseNodes(scene, 0);
    const EmbreeScene embree(scene, pose);
    DeviceTracer tracer(deviceOf(GetParam()), scene, pose);
    const auto rays = randomRays(100000, 0.5f);
    const auto expected = embree.occluded(rays);
    const auto hits = tracer.any(rays);
    size_t different = 0, blocked = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        different += bool(expected[i]) != (hits[i].hit.instance != INVALID_INDEX);
        blocked += expected[i];
    }
    EXPECT_LE(double(different), 1e-4 * double(rays.size()));
    EXPECT_GT(blocked, rays.size() / 10);
}

TEST_P(TraceTest, MovedNodesAreHitWhereTheyStandNow)
{
    const Scene scene = randomScene();
    DeviceTracer tracer(deviceOf(GetParam()), scene, poseNodes(scene, 0));
    const auto rays = randomRays(20000, 1e30f);
    std::vector<std::optional<glm::mat4>> overrides(scene.nodes.size());
    for (int step = 1; step <= 2;
         ++step) {  // the first move takes the node out of the static batch, the second does not
        overrides[0] = glm::translate(glm::mat4(1), glm::vec3(0.3f * float(step), 0, 0));
        overrides[3] = glm::scale(glm::mat4(1), glm::vec3(0.5f * float(step)));
        const auto pose = poseNodes(scene, 0, overrides);
        tracer.move(pose);
        EXPECT_LE(disagreement(tracer.closest(rays), EmbreeScene(scene, pose).closest(rays)), 1e-4) << "step " << step;
    }
}

/// Where a flat scene's cells are tiny across it, as they once were, points far off leave the range of floats.
TEST_P(TraceTest, AFlatSceneIsHitFromAfarWhateverItsSize)
{
    for (const float half : {1e-6f, 1.0f, 1e9f}) {
        const Scene scene = floorOf(half);
        const auto pose = poseNodes(scene, 0);
        DeviceTracer tracer(deviceOf(GetParam()), scene, pose);
        std::vector<Ray> rays;
        for (const Ray& ray : randomRays(1000, 1e30f)) {
            const glm::vec3 from = 3 * half * ray.origin,
                            to = half * glm::vec3(ray.direction.x, 0, ray.direction.z) / 3.0f;
            rays.push_back({from, glm::normalize(to - from), 1e30f});
        }
        const auto expected = EmbreeScene(scene, pose).closest(rays);
        EXPECT_LE(disagreement(tracer.closest(rays), expected), 1e-2) << "half a side: " << half;
        EXPECT_GT(
            std::count_if(expected.begin(), expected.end(), [](const auto& hit) { return hit.hit.instance == 0; }),
            400);
    }
}

INSTANTIATE_TEST_SUITE_P(BackEnds, TraceTest, testing::Values("software", "rayquery"),
                         [](const auto& info) { return std::string(info.param); });

/// The deepest leaf below a node, from 0.
uint32_t depthOf(const Bvh& bvh, int node)
{
    return node < 0 ? 0
                    : 1 + std::max(depthOf(bvh, bvh.nodes[size_t(node)].child0),
                                   depthOf(bvh, bvh.nodes[size_t(node)].child1));
}

/// Each lies so much farther off than the one before that the surface area heuristic splits one off after the other.
TEST(Bvh, HasOneBoxALeafAndFewLevelsHoweverTheBoxesLie)
{
    constexpr uint32_t LEVELS = 22;
    std::vector<Box> boxes;
    for (int i = 0; i < 1000; ++i) {
        const glm::vec3 corner(i < 16 ? std::pow(64.0f, float(i)) : 1e-3f * float(i), 0, 0);
        boxes.push_back({corner, corner + 1e-3f});
    }
    const Bvh bvh = buildBvh(boxes, 1);
    EXPECT_LE(depthOf(bvh, 0), LEVELS);
    std::vector<uint32_t> seen = bvh.order, all(boxes.size());
    std::sort(seen.begin(), seen.end());
    std::iota(all.begin(), all.end(), 0);
    EXPECT_EQ(seen, all);
    EXPECT_EQ(bvh.nodes.size(), boxes.size() - 1);
    const Bvh again = buildBvh(boxes, 1);
    EXPECT_EQ(again.order, bvh.order);
}

/// A scene of ../shared, where there is one.
class SharedSceneTraceTest : public testing::TestWithParam<const char*> {};

TEST_P(SharedSceneTraceTest, BackEndsAndEmbreeAgree)
{
    const char* folder = std::getenv("RESTIRPG_SHARED");
    const auto file = std::filesystem::path(folder ? folder : RESTIRPG_SOURCE "/../shared") / "scenes" / GetParam();
    if (!std::filesystem::exists(file))
        GTEST_SKIP()
            << file.filename().string()
            << " is not there: its rays are not compared; set RESTIRPG_SHARED to the folder that holds scenes/";
    const Scene scene = loadGltf(file);
    const auto pose = poseNodes(scene, 0);
    const EmbreeScene embree(scene, pose);
    DeviceTracer software(deviceOf("software"), scene, pose), rayQuery(deviceOf("rayquery"), scene, pose);
    const auto primary = primaryRays(scene, pose, 320, 180);
    const auto primaryHits = embree.closest(primary);
    for (const auto& rays : {primary, bounceRays(scene, pose, primary, primaryHits, 1)}) {
        const auto expected = embree.closest(rays), ours = software.closest(rays), queried = rayQuery.closest(rays);
        EXPECT_LE(disagreement(ours, expected), 1e-4);
        EXPECT_LE(disagreement(ours, queried), 1e-4);
    }
}

INSTANTIATE_TEST_SUITE_P(Scenes, SharedSceneTraceTest, testing::Values("veach_ajar.glb", "barcelona_pavilion.glb"),
                         [](const auto& info) {
                             return std::string(info.param).substr(0, std::string(info.param).find('.'));
                         });

}  // namespace
}  // namespace restirpg::test
