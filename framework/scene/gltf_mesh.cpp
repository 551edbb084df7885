// glTF primitives to the scene's triangles.
#include "scene/gltf_primitive.h"

#include <algorithm>
#include <cmath>

namespace restirpg::gltf {

namespace {

/// Corner lists of triangles, strips and fans [glTF 2.0, 3.7.2.1].
std::vector<glm::uvec3> assembleTriangles(const std::vector<uint32_t>& corners, int mode)
{
    std::vector<glm::uvec3> triangles;
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        triangles.reserve(corners.size() / 3);
        for (size_t i = 0; i + 2 < corners.size(); i += 3)
            triangles.emplace_back(corners[i], corners[i + 1], corners[i + 2]);
    } else {
        for (size_t i = 0; i + 2 < corners.size(); ++i) {
            if (mode == TINYGLTF_MODE_TRIANGLE_STRIP)
                triangles.emplace_back(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
            else
                triangles.emplace_back(corners[i + 1], corners[i + 2], corners[0]);
        }
    }
    return triangles;
}

/// Colours beyond 0..1 would reflect more light than arrives, or less than none.
void clampColors(const File& file, std::vector<glm::vec4>& colors)
{
    for (auto& color : colors) {
        const auto clamped = glm::clamp(color, 0.0f, 1.0f);
        if (clamped != color)
            warn("{}: vertex colours outside of 0..1 are clamped to that range", file.name());
        color = clamped;
    }
}

void readTriangles(const File& file, const tinygltf::Primitive& primitive, Source& source)
{
    std::vector<uint32_t> corners;
    if (primitive.indices >= 0) {
        corners = readIndices(file, primitive.indices, source.place + " indices");
    } else {
        corners.resize(source.positions.size());
        for (size_t i = 0; i < corners.size(); ++i)
            corners[i] = uint32_t(i);
    }
    for (size_t i = 0; i < corners.size(); ++i)
        if (corners[i] >= source.positions.size())
            fail("{}: {}: index {} is {}, but there are {} positions; export it again", file.name(), source.place, i,
                 corners[i], source.positions.size());
    source.triangles = assembleTriangles(corners, primitive.mode);
}

Source readPrimitive(const File& file, const tinygltf::Primitive& primitive, const std::string& place,
                     uint32_t defaultMaterial)
{
    Source source;
    source.place = place;
    source.material = primitive.material < 0 ? defaultMaterial : uint32_t(primitive.material);
    if (primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        fail("{}: {}: mode {} does not exist; export it again", file.name(), place, primitive.mode);
    if (!hasTriangles(file, primitive)) {
        warn("{}: {}: has no triangles (points, lines or no positions) and is left out", file.name(), place);
        return source;
    }
    source.positions = readAttribute<glm::vec3>(file, primitive.attributes, source, "POSITION", {TINYGLTF_TYPE_VEC3});
    for (size_t i = 0; i < source.positions.size(); ++i)
        if (glm::any(glm::greaterThan(glm::abs(source.positions[i]), glm::vec3(FARTHEST))))
            fail("{}: {} POSITION: vertex {} lies beyond {} m; repair the mesh and export it again", file.name(), place,
                 i, FARTHEST);
    source.normals = readAttribute<glm::vec3>(file, primitive.attributes, source, "NORMAL", {TINYGLTF_TYPE_VEC3});
    source.tangents = readAttribute<glm::vec4>(file, primitive.attributes, source, "TANGENT", {TINYGLTF_TYPE_VEC4});
    source.uv[0] = readAttribute<glm::vec2>(file, primitive.attributes, source, "TEXCOORD_0", {TINYGLTF_TYPE_VEC2});
    source.uv[1] = readAttribute<glm::vec2>(file, primitive.attributes, source, "TEXCOORD_1", {TINYGLTF_TYPE_VEC2});
    source.colors = readAttribute<glm::vec4>(file, primitive.attributes, source, "COLOR_0",
                                             {TINYGLTF_TYPE_VEC3, TINYGLTF_TYPE_VEC4});
    clampColors(file, source.colors);
    readTriangles(file, primitive, source);
    return source;
}

glm::vec3 normalizedOrZero(glm::vec3 v)
{
    const float length = glm::length(v);
    return length > 0 && std::isfinite(length) ? v / length : glm::vec3(0);
}

/// Turns one Source into triangles and vertices that share what can be shared.
class PrimitiveBuilder {
public:
    PrimitiveBuilder(const Source& source, const Material& material) : source_(source)
    {
        const auto& map = material.normalMap;
        const bool mapped = map.index != INVALID_INDEX && !source.uv[map.uvSet].empty();
        generated_ = mapped && (source.tangents.empty() || source.normals.empty());
        if (generated_)
            for (const auto& uv : source.uv[map.uvSet])
                mapUv_.emplace_back(glm::dot(map.row0, glm::vec3(uv, 1)), glm::dot(map.row1, glm::vec3(uv, 1)));
        for (auto& shared : shared_)
            shared.assign(source.normals.empty() ? 0 : source.positions.size(), INVALID_INDEX);
    }

    /// Append to the scene; indices are relative to the mesh's first vertex.
    void append(Scene& scene, uint32_t meshFirstVertex)
    {
        for (const auto& triangle : source_.triangles)
            addTriangle(triangle);
        if (generated_)
            generateTangents(triangles_, positions_, uv_, attributes_);
        const uint32_t base = uint32_t(scene.positions.size()) - meshFirstVertex;
        scene.positions.insert(scene.positions.end(), positions_.begin(), positions_.end());
        scene.attributes.insert(scene.attributes.end(), attributes_.begin(), attributes_.end());
        for (const auto& triangle : triangles_)
            scene.triangles.push_back(triangle + base);
        scene.materialOfTriangle.insert(scene.materialOfTriangle.end(), triangles_.size(), source_.material);
    }

private:
    void addTriangle(glm::uvec3 corners)
    {
        const auto& p = source_.positions;
        const auto face = normalizedOrZero(glm::cross(p[corners[1]] - p[corners[0]], p[corners[2]] - p[corners[0]]));
        const auto flat = face == glm::vec3(0) ? glm::vec3(0, 0, 1) : face;
        const bool mirrored = generated_ && mirroredUv({mapUv_[corners[0]], mapUv_[corners[1]], mapUv_[corners[2]]});
        glm::uvec3 triangle;
        for (int i = 0; i < 3; ++i)
            triangle[i] = vertexOf(corners[i], mirrored, flat);
        triangles_.push_back(triangle);
    }

    uint32_t vertexOf(uint32_t corner, bool mirrored, glm::vec3 flat)
    {
        if (source_.normals.empty())
            return addVertex(corner, flat);
        auto& shared = shared_[mirrored][corner];
        if (shared == INVALID_INDEX) {
            const auto normal = normalizedOrZero(source_.normals[corner]);
            shared = addVertex(corner, normal == glm::vec3(0) ? flat : normal);
        }
        return shared;
    }

    uint32_t addVertex(uint32_t corner, glm::vec3 normal)
    {
        VertexAttributes vertex{};
        vertex.normal = normal;
        if (!source_.tangents.empty() && !generated_) {
            const auto direction = normalizedOrZero(source_.tangents[corner]);
            if (direction != glm::vec3(0))
                vertex.tangent = glm::vec4(direction, source_.tangents[corner].w < 0 ? -1.0f : 1.0f);
        }
        vertex.uv0 = source_.uv[0].empty() ? glm::vec2(0) : source_.uv[0][corner];
        vertex.uv1 = source_.uv[1].empty() ? glm::vec2(0) : source_.uv[1][corner];
        vertex.color = source_.colors.empty() ? glm::vec4(1) : source_.colors[corner];
        positions_.push_back(source_.positions[corner]);
        attributes_.push_back(vertex);
        if (generated_)
            uv_.push_back(mapUv_[corner]);
        return uint32_t(positions_.size() - 1);
    }

    const Source& source_;
    bool generated_ = false;  ///< tangents are computed here
    std::vector<glm::vec2> mapUv_;  ///< the normal map's coordinates per source vertex
    std::array<std::vector<uint32_t>, 2> shared_;  ///< [mirrored][source vertex]: the vertex made of it
    std::vector<glm::vec3> positions_;
    std::vector<VertexAttributes> attributes_;
    std::vector<glm::vec2> uv_;
    std::vector<glm::uvec3> triangles_;
};

}  // namespace

bool hasTriangles(const File& file, const tinygltf::Primitive& primitive)
{
    const auto positions = primitive.attributes.find("POSITION");
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES || positions == primitive.attributes.end())
        return false;
    const auto& accessor = file.model.accessors[size_t(positions->second)];
    return accessor.bufferView >= 0 || accessor.sparse.isSparse || !primitive.targets.empty();
}

void clearNeedlessMasks(Scene& scene)
{
    std::vector<float> leastAlpha(scene.materials.size(), 1);
    for (const auto& mesh : scene.meshes)
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; ++t)
            for (int corner = 0; corner < 3; ++corner) {
                auto& least = leastAlpha[scene.materialOfTriangle[t]];
                least = std::min(least, scene.attributes[mesh.firstVertex + scene.triangles[t][corner]].color.a);
            }
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        auto& material = scene.materials[i];
        if (material.baseColorMap.index == INVALID_INDEX && material.alpha * leastAlpha[i] >= material.alphaCutoff)
            material.flags &= ~MATERIAL_ALPHA_MASK;
    }
}

uint32_t addMesh(const File& file, const Shape& shape, const Skin* skin, Scene& scene)
{
    const auto& source = file.model.meshes[size_t(shape.mesh)];
    SceneMesh mesh;
    mesh.name = source.name;
    mesh.firstVertex = uint32_t(scene.positions.size());
    mesh.firstTriangle = uint32_t(scene.triangles.size());
    for (size_t p = 0; p < source.primitives.size(); ++p) {
        auto place = label("mesh", size_t(shape.mesh), source.name);
        if (source.primitives.size() > 1)
            place += fmt::format(" primitive {}", p);
        auto primitive = readPrimitive(file, source.primitives[p], place, uint32_t(file.model.materials.size()));
        if (primitive.triangles.empty())
            continue;
        applyMorph(file, source.primitives[p], shape.weights, primitive);
        if (skin)
            applySkin(file, source.primitives[p], *skin, primitive);
        PrimitiveBuilder(primitive, scene.materials[primitive.material]).append(scene, mesh.firstVertex);
    }
    mesh.vertexCount = uint32_t(scene.positions.size()) - mesh.firstVertex;
    mesh.triangleCount = uint32_t(scene.triangles.size()) - mesh.firstTriangle;
    scene.meshes.push_back(mesh);
    return uint32_t(scene.meshes.size() - 1);
}

}  // namespace restirpg::gltf
