// Morph targets and skins in their rest pose.
#include "scene/gltf_primitive.h"

#include <cmath>
#include <limits>

namespace restirpg::gltf {

namespace {

/// The matrix that normals transform by, but for a positive factor; it exists where the inverse does not.
glm::mat3 normalMatrix(const glm::mat3& m)
{
    const float sign = glm::determinant(m) < 0 ? -1.0f : 1.0f;
    return sign * glm::mat3(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
}

/// Add one attribute of a morph target, where the target and the primitive have it. A component that the target lacks
/// stays: a tangent's sign, a colour's alpha.
template <typename V>
void addTarget(const File& file, const std::map<std::string, int>& target, float weight, const Source& source,
               const char* name, std::initializer_list<int> types, std::vector<V>& values)
{
    const auto displacements = readAttribute<V>(file, target, source, name, types, 0);
    for (size_t i = 0; i < displacements.size() && i < values.size(); ++i) {
        values[i] += weight * displacements[i];
        if (!glm::all(glm::lessThanEqual(glm::abs(values[i]), V(std::numeric_limits<float>::max()))))
            fail("{}: {} {}: morph targets move that of vertex {} beyond all floats; repair the mesh and export it "
                 "again",
                 file.name(), source.place, name, i);
    }
}

void checkPositions(const File& file, const Source& source)
{
    for (size_t i = 0; i < source.positions.size(); ++i)
        if (!glm::all(glm::lessThanEqual(glm::abs(source.positions[i]), glm::vec3(FARTHEST))))
            fail("{}: {}: skin or morph targets move vertex {} beyond {} m; repair the mesh and export it again",
                 file.name(), source.place, i, FARTHEST);
}

/// Sums over a vertex's joints.
struct Blend {
    glm::mat4 matrix{0};
    float weight = 0;
};

/// Add one set of four joints and weights a vertex; false where the primitive has no such set.
bool addJoints(const File& file, const tinygltf::Primitive& primitive, const Skin& skin, const Source& source, int set,
               std::vector<Blend>& blends)
{
    const auto joints = readAttribute<glm::vec4>(file, primitive.attributes, source, fmt::format("JOINTS_{}", set),
                                                 {TINYGLTF_TYPE_VEC4});
    const auto weights = readAttribute<glm::vec4>(file, primitive.attributes, source, fmt::format("WEIGHTS_{}", set),
                                                  {TINYGLTF_TYPE_VEC4});
    if (joints.empty() || weights.empty())
        return false;
    for (size_t v = 0; v < blends.size(); ++v)
        for (int i = 0; i < 4; ++i) {
            const float weight = weights[v][i];
            if (weight == 0)
                continue;
            if (!(joints[v][i] >= 0 && joints[v][i] < float(skin.joints.size())))
                fail("{}: {} JOINTS_{}: vertex {} has joint {} of {}; export it again", file.name(), source.place, set,
                     v, joints[v][i], skin.joints.size());
            blends[v].matrix += weight * skin.joints[size_t(joints[v][i])];
            blends[v].weight += weight;
        }
    return true;
}

}  // namespace

std::vector<glm::dmat4> restPose(const File& file)
{
    const auto& nodes = file.model.nodes;
    std::vector<int> parents(nodes.size(), -1);
    for (size_t i = 0; i < nodes.size(); ++i)
        for (const int child : nodes[i].children)
            parents[size_t(child)] = int(i);
    std::vector<glm::dmat4> pose(nodes.size());
    std::vector<bool> known(nodes.size());
    std::vector<size_t> chain;
    for (size_t i = 0; i < nodes.size(); ++i) {
        for (int node = int(i); node >= 0 && !known[size_t(node)]; node = parents[size_t(node)]) {
            chain.push_back(size_t(node));
            if (chain.size() > nodes.size())
                fail("{}: {}: is its own ancestor; export it again", file.name(), label("node", i, nodes[i].name));
        }
        for (; !chain.empty(); chain.pop_back()) {
            const size_t node = chain.back();
            const auto local = localMatrix(makeNode(file, node, -1));
            pose[node] = parents[node] < 0 ? local : pose[size_t(parents[node])] * local;
            known[node] = true;
        }
    }
    return pose;
}

Skin readSkin(const File& file, const Shape& shape, const std::vector<glm::dmat4>& rest)
{
    const auto& source = file.model.skins[size_t(shape.skin)];
    Skin skin;
    skin.place = rest[size_t(source.joints.empty() ? shape.node : source.joints[0])][3];
    const auto relative = [&](int node) {
        auto matrix = rest[size_t(node)];
        matrix[3] -= glm::dvec4(skin.place, 0);
        return matrix;
    };
    skin.unbound = relative(shape.node);
    for (const int joint : source.joints)
        skin.joints.emplace_back(relative(joint));
    if (source.inverseBindMatrices < 0)
        return skin;
    const auto place = label("skin", size_t(shape.skin), source.name) + " inverseBindMatrices";
    const auto values = readFloats(file, source.inverseBindMatrices, place, {TINYGLTF_TYPE_MAT4}, skin.joints.size());
    if (values.size() < 16 * skin.joints.size())
        fail("{}: {}: {} matrices for {} joints; export it again", file.name(), place, values.size() / 16,
             skin.joints.size());
    for (size_t j = 0; j < skin.joints.size(); ++j) {
        glm::dmat4 inverseBind;
        for (size_t i = 0; i < 16; ++i)
            inverseBind[int(i / 4)][int(i % 4)] = values[16 * j + i];
        skin.joints[j] = relative(source.joints[j]) * inverseBind;
    }
    return skin;
}

void applyMorph(const File& file, const tinygltf::Primitive& primitive, const std::vector<double>& weights,
                Source& source)
{
    for (size_t t = 0; t < primitive.targets.size() && t < weights.size(); ++t) {
        const float weight = float(weights[t]);
        if (weight == 0)
            continue;
        const auto add = [&](const char* name, std::initializer_list<int> types, auto& values) {
            addTarget(file, primitive.targets[t], weight, source, name, types, values);
        };
        add("POSITION", {TINYGLTF_TYPE_VEC3}, source.positions);
        add("NORMAL", {TINYGLTF_TYPE_VEC3}, source.normals);
        add("TANGENT", {TINYGLTF_TYPE_VEC3}, source.tangents);
        add("TEXCOORD_0", {TINYGLTF_TYPE_VEC2}, source.uv[0]);
        add("TEXCOORD_1", {TINYGLTF_TYPE_VEC2}, source.uv[1]);
        add("COLOR_0", {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4}, source.colors);
    }
    for (auto& color : source.colors)
        color = glm::clamp(color, 0.0f, 1.0f);
    checkPositions(file, source);
}

void applySkin(const File& file, const tinygltf::Primitive& primitive, const Skin& skin, Source& source)
{
    std::vector<Blend> blends(source.positions.size());
    for (int set = 0; addJoints(file, primitive, skin, source, set, blends); ++set) {
    }
    const bool bound = primitive.attributes.contains("JOINTS_0") && !skin.joints.empty();
    std::vector<bool> mirrored(blends.size());
    for (size_t v = 0; v < blends.size(); ++v) {
        // Weights add up to 1 but for rounding; a vertex without any follows the first joint.
        const auto matrix = !bound                 ? skin.unbound
                            : blends[v].weight > 0 ? blends[v].matrix / blends[v].weight
                                                   : skin.joints[0];
        const glm::mat3 linear(matrix);
        mirrored[v] = glm::determinant(linear) < 0;
        source.positions[v] = glm::vec3(matrix * glm::vec4(source.positions[v], 1));
        if (v < source.normals.size())
            source.normals[v] = normalMatrix(linear) * source.normals[v];
        if (v < source.tangents.size())
            source.tangents[v] = glm::vec4(linear * glm::vec3(source.tangents[v]),
                                           mirrored[v] ? -source.tangents[v].w : source.tangents[v].w);
    }
    // As under a node that mirrors: the front stays the front.
    for (auto& triangle : source.triangles)
        if (mirrored[triangle[0]])
            std::swap(triangle[1], triangle[2]);
    checkPositions(file, source);
}

}  // namespace restirpg::gltf
