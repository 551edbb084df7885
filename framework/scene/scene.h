// A scene on the host: what glTF says, ready to be uploaded. Knows no GPU.
#pragma once

#include "shaders/scene/scene_types.h"

#include <glm/gtc/quaternion.hpp>

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace restirpg {

/// Entries of node matrices and camera coordinates must be smaller in magnitude, so that their squares fit a float.
constexpr float LARGEST_ENTRY = 1e15f;
/// Vertical fields of view must be smaller, radians.
constexpr float LARGEST_YFOV = 3.14159f;

/// An image in memory. Exactly one of the two pixel arrays is filled. Rows from the top.
struct Texture {
    enum class Wrap { repeat, mirroredRepeat, clampToEdge };
    enum class Filter { linear, nearest };

    std::string name;
    uint32_t width = 0;
    uint32_t height = 0;
    bool srgb = false;  ///< bytes: r, g, b are sRGB encoded
    std::vector<uint8_t> bytes;  ///< RGBA8
    std::vector<float> floats;  ///< RGBA32F, linear
    Wrap wrapU = Wrap::repeat;
    Wrap wrapV = Wrap::repeat;
    Filter filter = Filter::linear;

    /// Linear RGBA of one texel.
    glm::vec4 texel(uint32_t x, uint32_t y) const;
};

/// One glTF mesh: the triangles of all of its primitives.
struct SceneMesh {
    std::string name;
    uint32_t firstVertex = 0;
    uint32_t vertexCount = 0;
    uint32_t firstTriangle = 0;
    uint32_t triangleCount = 0;
};

/// A node of the hierarchy, in an order in which parents come before children.
struct Node {
    std::string name;
    int parent = -1;  ///< index into Scene::nodes, -1: a root
    // Doubles, as a file has them: floats are coarse far from the origin.
    glm::dvec3 translation{0};
    glm::dquat rotation{1, 0, 0, 0};
    glm::dvec3 scale{1};
    std::optional<glm::dmat4> matrix;  ///< replaces translation, rotation and scale
    uint32_t gltfIndex = 0;  ///< index in the file
};

/// One channel of a node animation.
struct AnimationChannel {
    enum class Path { translation, rotation, scale };
    enum class Interpolation { step, linear, cubicSpline };

    uint32_t node = 0;
    Path path = Path::translation;
    Interpolation interpolation = Interpolation::linear;
    std::vector<float> times;  ///< seconds, ascending
    /// One a key; cubicSpline: in-tangent, value, out-tangent a key. Rotations as x, y, z, w.
    std::vector<glm::vec4> values;
};

/// A perspective camera attached to a node (it looks along the node's -z).
struct CameraNode {
    std::string name;
    uint32_t node = 0;
    float yfov = 0.7f;  ///< radians
};

/// A KHR_lights_punctual light attached to a node (it shines along the node's -z).
struct PunctualLight {
    uint32_t node = 0;
    uint32_t type = LIGHT_POINT;
    glm::vec3 intensity{1};  ///< W/sr (point, spot) or W/m^2 (directional), colour included
    float innerCone = 0;  ///< radians
    float outerCone = 0.7853982f;
};

/// Light from infinitely far away.
struct Environment {
    glm::vec3 radiance{0};  ///< constant radiance, or the factor of the texture
    /// Linear Rec.709, no negative or non-finite texels. Equirectangular: u = 0.5 + atan2(x, -z) / 2 pi, v = acos(y) /
    /// pi.
    std::optional<Texture> texture;
    float rotation = 0;  ///< radians about +y
};

/// What a user gave in place of a scene's own environment.
struct GivenEnvironment {
    std::string name;  ///< of the file, or "r,g,b"
    std::string hash;  ///< content hash of the file, 16 hexadecimal digits; empty for r,g,b
};

/// A mesh placed by a node.
struct InstanceNode {
    uint32_t mesh = 0;
    uint32_t node = 0;
};

/// What a vertex carries besides its position.
struct VertexAttributes {
    glm::vec3 normal{0};
    glm::vec4 tangent{0};  ///< w: sign of the bitangent; all zero: no tangent
    glm::vec2 uv0{0};
    glm::vec2 uv1{0};
    glm::vec4 color{1};  ///< linear COLOR_0, its alpha in a; 1 when absent
};

struct Scene {
    std::filesystem::path file;
    /// Everything it was read from: `file`, its buffers and images, the environment and what replaced it
    std::vector<std::filesystem::path> files;
    std::string hash;  ///< content hash of the file and everything it refers to, 16 hexadecimal digits
    std::optional<GivenEnvironment> givenEnvironment;  ///< `hash` does not cover it

    std::vector<Node> nodes;
    std::vector<AnimationChannel> channels;
    std::vector<SceneMesh> meshes;
    std::vector<InstanceNode> instances;
    std::vector<CameraNode> cameras;
    std::vector<PunctualLight> punctualLights;
    std::optional<Environment> environment;
    std::vector<Material> materials;
    std::vector<std::string> materialNames;  ///< as many, as in the file
    std::vector<Texture> textures;

    std::vector<glm::vec3> positions;  ///< per vertex, object space
    std::vector<VertexAttributes> attributes;  ///< per vertex
    std::vector<glm::uvec3> triangles;  ///< vertex indices relative to the mesh's firstVertex
    std::vector<uint32_t> materialOfTriangle;

    uint32_t camera = 0;  ///< into cameras
    /// The world position that poses are relative to: 0, but in the middle of scenes that lie far from 0 for their
    /// size.
    glm::vec3 origin{0};
    std::optional<uint32_t> bounceCap;  ///< asset extras "restirpg": {"bounces": n}: the scene's own bounce cap
    float duration = 0;  ///< s, the end of the last animation key

    uint64_t instancedTriangleCount() const;
};

/// A node's matrix towards its parent.
glm::dmat4 localMatrix(const Node& node);

/// World matrices of all nodes at a time, relative to Scene::origin, in the order of Scene::nodes. Times outside a
/// channel's keys are clamped. Every one has an inverse: what is scaled to nothing becomes thinner than anything seen
/// instead. Throws Error where one is not finite. `overrides` (empty, or one a node) replaces the local matrix of a
/// node that a user moved.
std::vector<glm::mat4> poseNodes(const Scene& scene, float time,
                                 const std::vector<std::optional<glm::mat4>>& overrides = {});

/// Turns the corners of every triangle so that the first is the one opposite its longest edge; the front stays. Rays of
/// a long thin triangle then start close to it, at any shape (find_clearance of triangle.glsl). It is longest as the
/// mesh's first instance stands at time 0: in another pose rays may start farther off. Of equal edges it is the one
/// opposite the earliest vertex, so that triangles which were turned before are turned to the same corner.
void startAtWidestCorners(Scene& scene);

struct Bounds {
    glm::vec3 lower{INFINITY};
    glm::vec3 upper{-INFINITY};

    void add(glm::vec3 p)
    {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
};

/// Whatever follows from the nodes' matrices, to be called when one has changed: Scene::origin and the triangles' first
/// corners. Returns the bounds in the world at time 0. Throws Error where the scene reaches too far.
Bounds deriveFromNodes(Scene& scene);

/// Per node: does its animation, or that of a node above it, ever move it?
std::vector<bool> animatedNodes(const Scene& scene);

/// The shader's camera for one of the scene's camera nodes and an image aspect (width / height).
Camera makeCamera(const CameraNode& camera, const glm::mat4& nodeToWorld, float aspect);

}  // namespace restirpg
