// Rays that leave a surface: they do not meet it again, and what lies close behind they do meet. Far from the origin
// and near it, large and small, at all tilts, in both back ends; as part of the static hierarchy and as objects with
// hierarchies of their own.
#include "trace/Shared.h"
#include "trace/devices.h"

#include "render/scene_gpu.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

#include <map>
#include <random>

namespace restirpg::test {
namespace {

constexpr Hit NONE{INVALID_INDEX, 0, {}};

std::mt19937 generator;

float uniform(float from, float to)
{
    return std::uniform_real_distribution<float>(from, to)(generator);
}

glm::vec3 randomDirection()
{
    std::normal_distribution<float> normal;
    return glm::normalize(glm::vec3(normal(generator), normal(generator), normal(generator)));
}

/// A turn by three random angles; in every fourth case none.
glm::mat4 randomTurn()
{
    const float angle = generator() % 4 ? uniform(-3, 3) : 0.0f;
    return glm::rotate(glm::mat4(1), angle, randomDirection());
}

/// Quads of two triangles, one a mesh and node.
struct Quads {
    Scene scene;

    Quads() { scene.materials.emplace_back(); }

    /// The quad [-1, 1]^2 at z = 0, placed by `baked` in its mesh and by `node` in the world. Its triangles start at
    /// their corner `first`; with 0 that is the right angle.
    uint32_t add(const glm::mat4& baked, const glm::mat4& matrix, uint32_t first = 0)
    {
        SceneMesh mesh;
        mesh.firstVertex = uint32_t(scene.positions.size());
        mesh.firstTriangle = uint32_t(scene.triangles.size());
        mesh.vertexCount = 4;
        mesh.triangleCount = 2;
        for (const auto& corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(1, 1), glm::vec2(-1, 1)})
            scene.positions.push_back(baked * glm::vec4(corner, 0, 1));
        for (const auto& corners : {glm::uvec3(1, 2, 0), glm::uvec3(3, 0, 2)})
            scene.triangles.emplace_back(corners[int(first % 3)], corners[int((first + 1) % 3)],
                                         corners[int((first + 2) % 3)]);
        scene.meshes.push_back(mesh);
        scene.attributes.resize(scene.positions.size());
        scene.materialOfTriangle.resize(scene.triangles.size());
        Node node;
        node.name = "node" + std::to_string(scene.nodes.size());
        node.matrix = matrix;
        scene.nodes.push_back(node);
        scene.instances.push_back({uint32_t(scene.meshes.size() - 1), uint32_t(scene.nodes.size() - 1)});
        return uint32_t(scene.instances.size() - 1);
    }
};

/// A point of a quad; some lie by an edge or a corner.
Hit randomPoint(uint32_t instance)
{
    glm::vec2 b(uniform(0, 1), uniform(0, 1));
    if (b.x + b.y > 1)
        b = 1.0f - b;
    if (generator() % 4 == 0)
        b.x *= 1e-4f;
    return {instance, uint32_t(generator() % 2), b};
}

/// Do the rays leave objects of the static hierarchy, or ones that have moved?
enum class Placed { still, moved };

struct Case {
    const char* backend;
    Placed placed;
};

void PrintTo(const Case& c, std::ostream* out)
{
    *out << c.backend << (c.placed == Placed::still ? ", still" : ", moved");
}

const Kernel& kernelOf(const std::string& backend)
{
    Device& device = deviceOf(backend);  // first: static objects are destroyed in the reverse order of their making
    static std::map<std::string, Kernel> kernels;
    auto& kernel = kernels[backend];
    if (!kernel) {
        device.setKernelDefine("RESTIRPG_ALPHA_MASK", "0");
        kernel = Kernel(device, RESTIRPG_SOURCE "/tests/trace/leave_surface.comp");
    }
    return kernel;
}

class ClearanceTest : public testing::TestWithParam<Case> {
protected:
    void SetUp() override { generator.seed(5); }

    /// Rays in random directions from random points of the first `instances`: none meets the instance that it left.
    void expectNoneMeetsItself(const Scene& scene, uint32_t instances, int raysEach)
    {
        std::vector<Departure> departures;
        for (uint32_t instance = 0; instance < instances; ++instance)
            for (int ray = 0; ray < raysEach; ++ray)
                departures.push_back({randomPoint(instance), NONE, randomDirection()});
        const auto arrivals = leave(scene, departures);
        size_t met = 0;
        for (size_t i = 0; i < departures.size(); ++i)
            met += arrivals[i].hit.instance == departures[i].from.instance;
        EXPECT_EQ(met, 0u) << "of " << departures.size() << " rays";
    }

    std::vector<Arrival> leave(const Scene& scene, const std::vector<Departure>& departures)
    {
        static_assert(sizeof(Departure) == 44 && sizeof(Arrival) == 24);
        Device& device = deviceOf(GetParam().backend);
        const auto pose = poseNodes(scene, 0);
        auto before = pose;
        if (GetParam().placed == Placed::moved)
            for (auto& matrix : before)
                matrix = glm::scale(glm::mat4(1), glm::vec3(2)) * matrix;
        SceneGpu gpu(device, scene, before);
        gpu.update(pose, &before);
        FrameConstants constants{};
        constants.scene = gpu.table();
        Buffer frame = device.createBuffer(sizeof constants, "frame constants");
        device.upload(frame, &constants, sizeof constants);
        const Buffer from = device.createBuffer(departures, "departures");
        const Buffer to = device.createBuffer(departures.size() * sizeof(Arrival), "arrivals");
        const LeaveSurfaceParameters parameters{frame.address(), from.address(), to.address(),
                                                uint32_t(departures.size())};
        device.submit([&](VkCommandBuffer commands) {
            gpu.bindings().bind(commands);
            kernelOf(GetParam().backend).dispatch(commands, &parameters, sizeof parameters, parameters.count);
        });
        return device.download<Arrival>(to, parameters.count);
    }
};

TEST_P(ClearanceTest, RaysDoNotMeetTheFlatSurfaceThatTheyLeave)
{
    constexpr int QUADS = 400, RAYS = 250;
    Quads quads;
    for (int i = 0; i < QUADS; ++i) {
        const float size = std::pow(10.0f, uniform(-4, 2.6f));  // 0.1 mm to 400 m
        const float narrow = i % 3 == 0 ? 0.01f : 1.0f;
        const glm::vec3 place = i % 2 ? glm::vec3(0) : uniform(0, 1e4f) * randomDirection();
        const glm::mat4 shape = glm::scale(glm::mat4(1), glm::vec3(size, size * narrow, size));
        const glm::mat4 there = glm::translate(glm::mat4(1), place) * randomTurn();
        if (i % 5 == 0)  // far from the origin of its own mesh
            quads.add(there * shape, randomTurn());
        else if (i % 5 == 1)
            quads.add(shape, there);
        else
            quads.add(glm::mat4(1), there * shape);
    }
    expectNoneMeetsItself(quads.scene, QUADS, RAYS);
}

TEST_P(ClearanceTest, NothingStandsBetweenTwoSurfacesThatFaceEachOther)
{
    constexpr int PAIRS = 200, RAYS = 500;
    Quads quads;
    for (int i = 0; i < PAIRS; ++i) {
        // Pairs lie far apart, in layers of their own.
        const int row = i / 10, layer = i % 10;
        const glm::vec3 place(1000.0f * float(row) - 10000.0f, 0, 1000.0f * float(layer) - 5000.0f);
        const glm::mat4 there = glm::translate(glm::mat4(1), place) * randomTurn();
        const float size = std::pow(10.0f, uniform(-2, 1.5f)), gap = std::pow(10.0f, uniform(-1, 2));
        quads.add(glm::scale(glm::mat4(1), glm::vec3(size)), there);
        // lavapipe's ray query finds a far triangle seen edge-on at any of its depths.
        const float reach = GetParam().backend == std::string("software") ? 200.0f : std::min(200.0f, 30 * gap);
        quads.add(glm::scale(glm::mat4(1), glm::vec3(reach)),
                  there * glm::translate(glm::mat4(1), glm::vec3(0, 0, gap)));
    }
    std::vector<Departure> departures;
    for (uint32_t pair = 0; pair < PAIRS; ++pair)
        for (int ray = 0; ray < RAYS; ++ray) {
            Departure departure{randomPoint(2 * pair), randomPoint(2 * pair + 1), {}};
            if (ray % 2)
                std::swap(departure.from, departure.to);
            departures.push_back(departure);
        }
    const auto arrivals = leave(quads.scene, departures);
    size_t blocked = 0;
    for (const auto& arrival : arrivals)
        blocked += arrival.hit.instance != INVALID_INDEX;
    // lavapipe's ray query finds some triangles before a ray's end that lie behind it: 222, whatever the clearance.
    const size_t allowed = GetParam().backend == std::string("software") ? 0 : departures.size() / 200;
    EXPECT_LE(blocked, allowed) << "of " << departures.size() << " rays";
}

/// Strips of all sizes, a ten-thousandth as wide as long, whose triangles start at any of their corners.
TEST_P(ClearanceTest, RaysDoNotMeetTheStripThatTheyLeave)
{
    constexpr uint32_t STRIPS = 300;
    constexpr int RAYS = 250;
    Quads quads;
    for (uint32_t i = 0; i < STRIPS; ++i) {
        const float length = std::pow(10.0f, uniform(-2, 3));  // 1 cm to 1 km
        const glm::vec3 place = i % 2 ? glm::vec3(0) : uniform(0, 1e4f) * randomDirection();
        const glm::mat4 shape = glm::scale(glm::mat4(1), glm::vec3(length, 1e-4f * length, length));
        const glm::mat4 there = glm::translate(glm::mat4(1), place) * randomTurn();
        if (i / 3 % 2)
            quads.add(shape, there, i % 3);
        else
            quads.add(glm::mat4(1), there * shape, i % 3);
    }
    expectNoneMeetsItself(quads.scene, STRIPS, RAYS);
}

/// The reader has turned the strip's triangles, so that rays start much closer to it than it is wide.
TEST_P(ClearanceTest, WhatLiesCloseBehindAStripIsMet)
{
    constexpr int RAYS = 50;
    for (float length : {0.01f, 1.0f, 30.0f, 1000.0f})
        for (uint32_t first = 0; first < 3; ++first) {
            const float width = 1e-4f * length;
            const glm::mat4 there = glm::translate(glm::mat4(1), length * randomDirection()) * randomTurn();
            Quads quads;
            const auto add = [&](const glm::mat4& shape) { return quads.add(there * shape, glm::mat4(1), first); };
            const uint32_t front = add(glm::scale(glm::mat4(1), {length, width, 1}));
            add(glm::translate(glm::mat4(1), glm::vec3(0, 0, -0.1f * width)) *
                glm::scale(glm::mat4(1), glm::vec3(2 * length)));
            startAtWidestCorners(quads.scene);
            std::vector<Departure> departures;
            for (int ray = 0; ray < RAYS; ++ray)
                departures.push_back(
                    {randomPoint(front), NONE, glm::mat3(there) * glm::vec3(uniform(-1, 1), uniform(-1, 1), -1)});
            size_t missed = 0;
            for (const auto& arrival : leave(quads.scene, departures))
                missed += arrival.hit.instance != front + 1;
            EXPECT_EQ(missed, 0u) << "of " << departures.size() << " rays, " << length << " m from corner " << first;
        }
}

TEST(BvhBuild, ThousandsOfTrianglesInOnePlaceMakeAHierarchy)
{
    const std::vector<SourceTriangle> triangles(5000, {{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, 0, 0});
    EXPECT_GE(buildTriangleBvh(triangles).triangles.size(), triangles.size());
}

/// Panes are two quads of 2 m, thin, at some distance from the origin, all scaled. Thinner ones could not be told from
/// one quad: in the world's floats their sides round to much the same places.
TEST_P(ClearanceTest, TheBackOfAThinPaneIsMetFromItsFront)
{
    const float thinnest = GetParam().backend == std::string("software") ? 4e-7f : 4e-6f;  // of the distance
    constexpr int PANES = 6, RAYS = 50;
    for (float scale : {1.0f, 1e-4f, 1e4f})
        for (float thickness : {0.0005f, 0.002f, 0.006f})
            for (float distance : {4.0f, 30.0f, 300.0f, 1200.0f, 5000.0f, 10000.0f}) {
                if (thickness < thinnest * distance)
                    continue;
                Quads quads;
                std::vector<Departure> departures;
                const glm::mat4 turn = randomTurn();
                for (int i = 0; i < PANES; ++i) {
                    glm::vec3 place(0);
                    place[i / 2] = i % 2 ? distance : -distance;
                    const glm::mat4 there = glm::scale(glm::mat4(1), glm::vec3(scale)) * turn *
                                            glm::translate(glm::mat4(1), place) * randomTurn();
                    const uint32_t front = quads.add(glm::mat4(1), there);
                    quads.add(glm::translate(glm::mat4(1), glm::vec3(0, 0, -thickness)), there);
                    for (int ray = 0; ray < RAYS; ++ray) {
                        Hit from = randomPoint(front);
                        from.barycentrics =
                            0.1f + 0.7f * from.barycentrics;  // rays shall not pass by the other quad's edge
                        departures.push_back(
                            {from, NONE, glm::mat3(there) * glm::vec3(uniform(-1, 1), uniform(-1, 1), -1)});
                    }
                }
                size_t missed = 0;
                const auto arrivals = leave(quads.scene, departures);
                for (size_t i = 0; i < departures.size(); ++i)
                    missed += arrivals[i].hit.instance != departures[i].from.instance + 1;
                EXPECT_EQ(missed, 0u) << "of " << departures.size() << " rays, scale " << scale << ", " << thickness
                                      << " m at " << distance << " m";
            }
}

INSTANTIATE_TEST_SUITE_P(BackEnds, ClearanceTest,
                         testing::Values(Case{"software", Placed::still}, Case{"software", Placed::moved},
                                         Case{"rayquery", Placed::still}),
                         [](const auto& info) {
                             return std::string(info.param.backend) +
                                    (info.param.placed == Placed::still ? "Still" : "Moved");
                         });

}  // namespace
}  // namespace restirpg::test
