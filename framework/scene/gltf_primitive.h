// Inside the glTF reader: a primitive's arrays on their way from the file to the scene.
#pragma once

#include "scene/gltf_file.h"

#include <map>

namespace restirpg::gltf {

/// Coordinates whose squares and products stay far inside float's range.
constexpr float FARTHEST = 1e9f;

/// A primitive's arrays as the file has them, before vertices are shared or split.
struct Source {
    std::string place;  ///< for messages
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;  ///< empty: flat
    std::vector<glm::vec4> tangents;  ///< empty: none, or to be generated
    std::array<std::vector<glm::vec2>, 2> uv;  ///< empty: zeros
    std::vector<glm::vec4> colors;  ///< empty: ones
    std::vector<glm::uvec3> triangles;
    uint32_t material = 0;
};

/// What a node shows: a mesh with its morph weights and its skin applied. Nodes that agree in all of it share the
/// triangles.
struct Shape {
    int mesh = -1;
    std::vector<double> weights;  ///< of the morph targets; those missing are 0
    int skin = -1;
    int node = -1;  ///< with a skin: the node, whose matrix places the primitives without joints

    auto operator<=>(const Shape&) const = default;  // NOLINT(modernize-use-nullptr): its 0 is clang-tidy 14's own
};

/// A skin in its rest pose.
struct Skin {
    /// Where the first joint stands in the world. The matrices are relative to it: far from the origin floats are
    /// coarse.
    glm::dvec3 place{0};
    std::vector<glm::mat4> joints;  ///< matrix of each joint times its inverse bind matrix
    glm::mat4 unbound{1};  ///< of primitives without joints
};

/// Does a primitive have triangles, as far as its description says? Positions without data all lie at the origin.
bool hasTriangles(const File& file, const tinygltf::Primitive& primitive);

/// Append the triangles of a shape as a mesh of the scene, empty where it has none; its index.
uint32_t addMesh(const File& file, const Shape& shape, const Skin* skin, Scene& scene);

/// A surface that is opaque everywhere is spared the alpha test on every ray.
void clearNeedlessMasks(Scene& scene);

/// World matrices of the file's nodes without animation; singular ones stay singular.
std::vector<glm::dmat4> restPose(const File& file);

Skin readSkin(const File& file, const Shape& shape, const std::vector<glm::dmat4>& rest);

/// Add the morph targets' displacements times their weights [glTF 2.0, 3.7.2.2]. Colours stay within 0..1.
void applyMorph(const File& file, const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                Source& source);

/// Move vertices by the weighted mean of their joints' matrices, into the world, relative to the skin's place [glTF
/// 2.0, 3.7.3.3].
void applySkin(const File& file, const tinygltf::Primitive& primitive, const Skin& skin, Source& source);

/// Regroup floats; a component that the file lacks is `missing`.
template <typename V>
std::vector<V> toVectors(const std::vector<float>& values, size_t stride, float missing)
{
    std::vector<V> vectors(values.size() / stride, V(missing));
    for (size_t i = 0; i < vectors.size(); ++i)
        for (size_t c = 0; c < stride; ++c)
            vectors[i][int(c)] = values[i * stride + c];
    return vectors;
}

/// Read an optional attribute; its count must be that of the positions. A component that the file lacks is `missing`
/// (the alpha of a COLOR_0 of three is 1).
template <typename V>
std::vector<V> readAttribute(const File& file, const std::map<std::string, int>& attributes, const Source& source,
                             const std::string& name, std::initializer_list<int> types, float missing = 1)
{
    const auto found = attributes.find(name);
    if (found == attributes.end())
        return {};
    const auto place = fmt::format("{} {}", source.place, name);
    const auto& accessor = file.model.accessors[size_t(found->second)];
    if (!source.positions.empty() && accessor.count != source.positions.size())
        fail("{}: {}: accessor {} has {} elements for {} positions; export it again", file.name(), place, found->second,
             accessor.count, source.positions.size());
    const auto values = readFloats(file, found->second, place, types);
    return toVectors<V>(values, size_t(tinygltf::GetNumComponentsInType(uint32_t(accessor.type))), missing);
}

}  // namespace restirpg::gltf
