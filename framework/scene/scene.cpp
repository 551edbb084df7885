#include "scene/scene.h"

#include "core/error.h"
#include "scene/srgb.h"

#include <glm/gtc/matrix_transform.hpp>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace restirpg {

namespace {

glm::dquat asQuaternion(const glm::dvec4& v)
{
    return {v.w, v.x, v.y, v.z};
}

/// Cubic Hermite with tangents per second [glTF 2.0, appendix C]; `key` and `key + 1` enclose the time.
glm::dvec4 cubicSpline(const AnimationChannel& channel, size_t key, double t, double seconds)
{
    const auto value = [&](size_t i) { return glm::dvec4(channel.values[3 * key + i]); };
    const auto value0 = value(1), out0 = value(2), in1 = value(3), value1 = value(4);
    const double t2 = t * t, t3 = t2 * t;
    return (2 * t3 - 3 * t2 + 1) * value0 + seconds * (t3 - 2 * t2 + t) * out0 + (-2 * t3 + 3 * t2) * value1 +
           seconds * (t3 - t2) * in1;
}

glm::dvec4 valueAt(const AnimationChannel& channel, float time)
{
    const bool cubic = channel.interpolation == AnimationChannel::Interpolation::cubicSpline;
    const auto keyValue = [&](size_t key) { return glm::dvec4(channel.values[cubic ? 3 * key + 1 : key]); };
    const auto& times = channel.times;
    if (!(time > times.front()))  // nor is NaN
        return keyValue(0);
    if (time >= times.back())
        return keyValue(times.size() - 1);
    const size_t key = size_t(std::upper_bound(times.begin(), times.end(), time) - times.begin()) - 1;
    if (channel.interpolation == AnimationChannel::Interpolation::step)
        return keyValue(key);
    const double seconds = double(times[key + 1]) - times[key];
    const double t = (double(time) - times[key]) / seconds;
    if (cubic)
        return cubicSpline(channel, key, t, seconds);
    if (channel.path != AnimationChannel::Path::rotation)
        return glm::mix(keyValue(key), keyValue(key + 1), t);
    const auto rotation =
        glm::slerp(glm::normalize(asQuaternion(keyValue(key))), glm::normalize(asQuaternion(keyValue(key + 1))), t);
    return {rotation.x, rotation.y, rotation.z, rotation.w};
}

/// Thickness of what is flat, in parts of its extent: above float's rounding. And the extent of what is a line or a
/// point, m.
constexpr float THINNEST = 1e-5f;
constexpr float SMALLEST = 1e-9f;

/// The longest of three vectors.
glm::vec3 longest(glm::vec3 a, glm::vec3 b, glm::vec3 c)
{
    const float aa = glm::dot(a, a), bb = glm::dot(b, b), cc = glm::dot(c, c);
    return aa >= bb && aa >= cc ? a : bb >= cc ? b : c;
}

/// Perpendicular to all three columns of a matrix of rank 2; of no length where they are parallel.
glm::vec3 missingDirection(const glm::mat3& m)
{
    return longest(glm::cross(m[0], m[1]), glm::cross(m[1], m[2]), glm::cross(m[2], m[0]));
}

/// Is the volume nothing but rounding, beside the columns' lengths and beside the rows'? A needle's is not.
bool isFlat(const glm::mat3& m)
{
    constexpr float ROUNDING = 1e-6f;
    const auto box = [](const glm::mat3& sides) {
        return glm::length(sides[0]) * glm::length(sides[1]) * glm::length(sides[2]);
    };
    return std::abs(glm::determinant(m)) <= ROUNDING * std::min(box(m), box(glm::transpose(m)));
}

/// A matrix that has an inverse as it is. Of one scaled by 0 along an axis (valid glTF: a flat mesh) with some
/// thickness; of one scaled by 0 along more (a hidden mesh) a speck.
glm::mat4 invertible(const glm::mat4& matrix)
{
    const glm::mat3 given(matrix);
    const float extent = glm::length(longest(given[0], given[1], given[2]));
    const auto placed = [&](const glm::mat3& m) {
        return glm::mat4(glm::vec4(m[0], 0), glm::vec4(m[1], 0), glm::vec4(m[2], 0), matrix[3]);
    };
    if (!(extent > 1e-3f * SMALLEST))
        return placed(glm::mat3(SMALLEST));
    auto m = given / extent;
    if (!isFlat(m))
        return matrix;
    const auto image = missingDirection(m), preimage = missingDirection(glm::transpose(m));
    if (!(glm::length(image) > THINNEST && glm::length(preimage) > THINNEST))
        return placed(glm::mat3(SMALLEST));
    const auto thickness = THINNEST * glm::outerProduct(glm::normalize(image), glm::normalize(preimage));
    m += glm::determinant(m + thickness) < 0 ? -thickness : thickness;
    return placed(m * extent);
}

/// The cross product of two edges of a larger triangle can have a square beyond float's range: kernels would find no
/// normal, and the surface would be black.
constexpr float LARGEST_SCENE = 3e9f;

/// Exact bounds of all instances at time 0.
Bounds worldBounds(const Scene& scene)
{
    const auto pose = poseNodes(scene, 0);
    Bounds bounds;
    for (const auto& instance : scene.instances) {
        const auto& mesh = scene.meshes[instance.mesh];
        const auto& matrix = pose[instance.node];
        for (uint32_t v = 0; v < mesh.vertexCount; ++v)
            bounds.add(glm::vec3(matrix * glm::vec4(scene.positions[mesh.firstVertex + v], 1)));
    }
    return bounds;
}

/// Where coordinates are relative to: the middle of a scene that lies farther off than FAR of its own radii, where
/// floats would be coarse.
glm::vec3 originOf(const Bounds& bounds)
{
    constexpr float FAR = 64;
    const auto center = 0.5f * (bounds.lower + bounds.upper);
    const float radius = 0.5f * glm::length(bounds.upper - bounds.lower);
    return glm::length(center) > FAR * radius ? center : glm::vec3(0);
}

}  // namespace

glm::dmat4 localMatrix(const Node& node)
{
    if (node.matrix)
        return *node.matrix;
    return glm::scale(glm::translate(glm::dmat4(1), node.translation) * glm::mat4_cast(node.rotation), node.scale);
}

glm::vec4 Texture::texel(uint32_t x, uint32_t y) const
{
    const size_t first = (size_t(y) * width + x) * 4;
    if (!floats.empty())
        return {floats[first], floats[first + 1], floats[first + 2], floats[first + 3]};
    static const auto table = [] {
        std::array<float, 256> values;
        for (size_t i = 0; i < values.size(); ++i)
            values[i] = srgbToLinear(float(i) / 255.0f);
        return values;
    }();
    const auto color = [&](size_t c) {
        const uint8_t byte = bytes[first + c];
        return srgb ? table[byte] : float(byte) / 255.0f;
    };
    return {color(0), color(1), color(2), float(bytes[first + 3]) / 255.0f};
}

uint64_t Scene::instancedTriangleCount() const
{
    uint64_t count = 0;
    for (const auto& instance : instances)
        count += meshes[instance.mesh].triangleCount;
    return count;
}

std::vector<bool> animatedNodes(const Scene& scene)
{
    std::vector<bool> animated(scene.nodes.size());
    for (const auto& channel : scene.channels)
        animated[channel.node] = true;
    for (size_t i = 0; i < scene.nodes.size(); ++i)  // parents come first
        if (scene.nodes[i].parent >= 0 && animated[size_t(scene.nodes[i].parent)])
            animated[i] = true;
    return animated;
}

std::vector<glm::mat4> poseNodes(const Scene& scene, float time, const std::vector<std::optional<glm::mat4>>& overrides)
{
    std::unordered_map<uint32_t, Node> animated;  // by their place
    for (const auto& channel : scene.channels) {
        const auto value = valueAt(channel, time);
        auto& node = animated.try_emplace(channel.node, scene.nodes[channel.node]).first->second;
        switch (channel.path) {
        case AnimationChannel::Path::translation:
            node.translation = glm::dvec3(value);
            break;
        case AnimationChannel::Path::scale:
            node.scale = glm::dvec3(value);
            break;
        case AnimationChannel::Path::rotation: {
            const double length = glm::length(value);
            node.rotation = length > 0 ? asQuaternion(value / length) : glm::dquat(1, 0, 0, 0);
        }
        }
    }
    // In double until the origin is taken off: what stands far from the world's origin keeps its place to a fraction of
    // its own size.
    const auto& nodes = scene.nodes;
    std::vector<glm::dmat4> world(nodes.size());
    for (size_t i = 0; i < nodes.size(); ++i) {
        const auto moved = animated.find(uint32_t(i));
        const bool given = i < overrides.size() && overrides[i];
        const auto local =
            given ? glm::dmat4(*overrides[i]) : localMatrix(moved == animated.end() ? nodes[i] : moved->second);
        world[i] = nodes[i].parent < 0 ? local : world[size_t(nodes[i].parent)] * local;
    }
    std::vector<glm::mat4> pose(nodes.size());
    for (size_t i = 0; i < nodes.size(); ++i) {
        world[i][3] -= glm::dvec4(scene.origin, 0);
        pose[i] = glm::mat4(world[i]);
        for (int column = 0; column < 4; ++column)
            if (!glm::all(glm::lessThan(glm::abs(pose[i][column]), glm::vec4(LARGEST_ENTRY))))
                fail("{}: node {} '{}': its matrix reaches {} at {} s; make its transform smaller, or that of a node "
                     "above it",
                     scene.file.string(), i, nodes[i].name, LARGEST_ENTRY, time);
        pose[i] = invertible(pose[i]);
    }
    return pose;
}

void startAtWidestCorners(Scene& scene)
{
    const auto pose = poseNodes(scene, 0);
    std::vector<bool> seen(scene.meshes.size());
    for (const auto& instance : scene.instances) {
        if (seen[instance.mesh])
            continue;
        seen[instance.mesh] = true;
        const auto& mesh = scene.meshes[instance.mesh];
        const glm::dmat3 toWorld(pose[instance.node]);
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; ++t) {
            auto& triangle = scene.triangles[t];
            const auto edge = [&](int from, int to) {
                return glm::length(toWorld * (glm::dvec3(scene.positions[mesh.firstVertex + triangle[to]]) -
                                              glm::dvec3(scene.positions[mesh.firstVertex + triangle[from]])));
            };
            const double opposite[3] = {edge(1, 2), edge(2, 0), edge(0, 1)};
            int first = 0;
            for (const int i : {1, 2})
                if (opposite[i] > opposite[first] || (opposite[i] == opposite[first] && triangle[i] < triangle[first]))
                    first = i;
            triangle = {triangle[first], triangle[(first + 1) % 3], triangle[(first + 2) % 3]};
        }
    }
}

Bounds deriveFromNodes(Scene& scene)
{
    scene.origin = glm::vec3(0);
    const auto bounds = worldBounds(scene);
    if (!(glm::length(bounds.upper - bounds.lower) + glm::length(bounds.upper) < LARGEST_SCENE))
        fail("{}: the scene reaches beyond {} m; check the scale of its nodes", scene.file.string(), LARGEST_SCENE);
    scene.origin = originOf(bounds);
    startAtWidestCorners(scene);
    return bounds;
}

Camera makeCamera(const CameraNode& camera, const glm::mat4& nodeToWorld, float aspect)
{
    // Scale and mirroring of the node do not act on its camera [glTF 2.0, 3.10].
    const auto backward = glm::vec3(nodeToWorld[2]), upward = glm::vec3(nodeToWorld[1]);
    const auto right = glm::cross(upward, backward);
    const float scale = glm::length(upward) * glm::length(backward);
    if (!(glm::length(right) > 1e-6f * scale) || !std::isfinite(scale))
        fail("camera '{}': its node's matrix is singular, so that it has no viewing direction; give the node a proper "
             "rotation",
             camera.name);
    const float halfHeight = std::tan(0.5f * camera.yfov);
    Camera result;
    result.position = glm::vec3(nodeToWorld[3]);
    result.forward = -glm::normalize(backward);
    result.right = glm::normalize(right) * (halfHeight * aspect);
    result.up = glm::normalize(glm::cross(backward, right)) * halfHeight;
    return result;
}

}  // namespace restirpg
