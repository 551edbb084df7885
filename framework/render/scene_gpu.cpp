#include "render/scene_gpu.h"

#include "scene/energy_table.h"
#include "shaders/restir/path_vertex_types.h"

#include <algorithm>
#include <map>

namespace restirpg {
namespace {

uint32_t wrapMode(Texture::Wrap wrap)
{
    switch (wrap) {
    case Texture::Wrap::mirroredRepeat:
        return TEXTURE_MIRROR;
    case Texture::Wrap::clampToEdge:
        return TEXTURE_CLAMP;
    default:
        return TEXTURE_REPEAT;
    }
}

/// TextureImage::shape.
uint64_t shapeOf(const Texture& texture)
{
    uint32_t flags = wrapMode(texture.wrapU) | wrapMode(texture.wrapV) << TEXTURE_WRAP_BITS;
    flags |= texture.filter == Texture::Filter::nearest ? TEXTURE_NEAREST : 0;
    flags |= texture.srgb ? TEXTURE_SRGB : 0;
    flags |= texture.floats.empty() ? 0 : TEXTURE_FLOAT;
    return texture.width | uint64_t(texture.height) << TEXTURE_SIDE_BITS | uint64_t(flags) << (2 * TEXTURE_SIDE_BITS);
}

std::vector<TextureRef> mapsOf(const Material& m)
{
    std::vector<TextureRef> maps;
    for (const auto& map :
         {m.baseColorMap, m.metallicRoughnessMap, m.normalMap, m.transmissionMap, m.specularMap, m.specularColorMap})
        if (map.index != INVALID_INDEX)
            maps.push_back(map);
    return maps;
}

/// Does shading with it read tangents or second texture coordinates?
bool readsExtras(const Material& material)
{
    const auto maps = mapsOf(material);
    return material.normalMap.index != INVALID_INDEX ||
           std::any_of(maps.begin(), maps.end(), [](const TextureRef& map) { return map.uvSet != 0; });
}

bool isColored(std::span<const VertexAttributes> attributes, const glm::uvec3& corners)
{
    const auto white = [&](uint32_t v) { return glm::vec3(attributes[v].color) == glm::vec3(1); };
    return !(white(corners.x) && white(corners.y) && white(corners.z));
}

bool hasAlphaMask(const Scene& scene)
{
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& material) { return material.flags & MATERIAL_ALPHA_MASK; });
}

/// Adds to a count of bytes what is allocated on the device while it lives, less what is freed.
class Counted {
public:
    Counted(const Device& device, uint64_t& bytes) : device_(device), bytes_(bytes), before_(device.allocatedBytes()) {}
    ~Counted() { bytes_ += device_.allocatedBytes() - before_; }
    Counted(const Counted&) = delete;
    Counted& operator=(const Counted&) = delete;

private:
    const Device& device_;
    uint64_t& bytes_;
    const uint64_t before_;
};

}  // namespace

SceneGpu::SceneGpu(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose, bool energyCompensation)
    : device_(device), scene_(scene), bindings_(device)
{
    const Counted counted(device, bytes_);
    device.changeKernelDefine("RESTIRPG_ALPHA_MASK", hasAlphaMask(scene) ? "1" : "0");
    uploadGeometry();
    if (energyCompensation)
        uploadEnergyTables();
    uploadMaterials();
    uploadTextures();
    placeInstances(pose);
    createAcceleration();
    refreshInstances();
    uploadLights(pose);
    pose_ = previousPose_ = pose;
}

Buffer& SceneGpu::keep(Buffer buffer)
{
    return buffers_.emplace_back(std::move(buffer));
}

void SceneGpu::uploadGeometry()
{
    std::vector<MeshVertex> vertices;
    std::vector<VertexExtras> extras;
    vertices.reserve(scene_.positions.size());
    extras.reserve(scene_.positions.size());
    for (size_t v = 0; v < scene_.positions.size(); ++v) {
        const auto& a = scene_.attributes[v];
        vertices.push_back({scene_.positions[v], a.normal, a.uv0});
        extras.push_back({a.tangent, a.uv1, a.color});
    }
    std::vector<MeshTriangle> triangles(scene_.triangles.size());
    for (const auto& mesh : scene_.meshes)
        for (uint32_t t = mesh.firstTriangle; t < mesh.firstTriangle + mesh.triangleCount; ++t) {
            const glm::uvec3 corners = scene_.triangles[t] + mesh.firstVertex;
            const uint32_t material = scene_.materialOfTriangle[t];
            const bool needsExtras = readsExtras(scene_.materials[material]) || isColored(scene_.attributes, corners);
            triangles[t] = {corners, material | (needsExtras ? TRIANGLE_EXTRAS : 0)};
        }
    table_.vertices = keep(device_.createBuffer(vertices, "vertices")).address();
    table_.vertexExtras = keep(device_.createBuffer(extras, "vertex extras")).address();
    table_.triangles = keep(device_.createBuffer(triangles, "triangles")).address();
}

/// One table for each index of refraction that the materials have.
void SceneGpu::uploadEnergyTables()
{
    device_.changeKernelDefine("RESTIRPG_ENERGY_COMPENSATION", "1");
    std::vector<glm::vec4> tables;
    for (const Material& material : scene_.materials) {
        if (!energyTableOf_.try_emplace(material.ior, uint32_t(energyTableOf_.size())).second)
            continue;
        const auto table = energyTable(material.ior);
        tables.insert(tables.end(), table.begin(), table.end());
    }
    table_.energyTables = keep(device_.createBuffer(tables, "energy tables")).address();
}

void SceneGpu::uploadMaterials()
{
    std::vector<Material> materials = scene_.materials;
    for (Material& material : materials) {
        if (material.transmission == 0) {  // nothing is inside of what lets no light in; an edit may change that
            material.flags &= ~MATERIAL_SOLID;
            material.absorption = glm::vec3(0);
        }
        material.flags |= mapsOf(material).empty() ? 0 : MATERIAL_TEXTURED;
        material.flags |= material.emissiveMap.index == INVALID_INDEX ? 0 : MATERIAL_EMISSION_TEXTURED;
        if (!energyTableOf_.empty())
            material.energyTable = energyTableOf_.at(material.ior);
    }
    materialBuffer_ = device_.createBuffer(materials, "materials");
    table_.materials = materialBuffer_.address();
}

void SceneGpu::createAcceleration()
{
    if (device_.backend() == Backend::software) {
        software_ = std::make_unique<SoftwareTracing>(device_, scene_, instances_);
        oneLevel_ = software_->isOneLevel();
        device_.changeKernelDefine("RESTIRPG_ONE_LEVEL", oneLevel_ ? "1" : "0");
        return;
    }
    const uint64_t indices = keep(device_.createBuffer(scene_.triangles, "indices")).address();
    std::vector<AccelerationMesh> meshes;
    for (const auto& mesh : scene_.meshes) {
        const auto first = scene_.materialOfTriangle.begin() + mesh.firstTriangle;
        const bool masked = std::any_of(first, first + mesh.triangleCount, [&](uint32_t material) {
            return scene_.materials[material].flags & MATERIAL_ALPHA_MASK;
        });
        meshes.push_back({table_.vertices + mesh.firstVertex * sizeof(MeshVertex),
                          indices + mesh.firstTriangle * sizeof(glm::uvec3), mesh.vertexCount, mesh.triangleCount,
                          !masked});
    }
    acceleration_ = std::make_unique<AccelerationStructures>(device_, meshes);
}

void SceneGpu::uploadTextures()
{
    std::vector<TextureImage> images;
    const auto upload = [&](const Texture& texture) {
        Buffer texels = texture.floats.empty() ? device_.createBuffer(texture.bytes, texture.name)
                                               : device_.createBuffer(texture.floats, texture.name);
        images.push_back({keep(std::move(texels)).address(), shapeOf(texture)});
    };
    std::for_each(scene_.textures.begin(), scene_.textures.end(), upload);
    table_.environmentTexture = INVALID_INDEX;
    if (scene_.environment) {
        table_.environmentRadiance = scene_.environment->radiance;
        table_.environmentRotation = scene_.environment->rotation;
        if (scene_.environment->texture) {
            table_.environmentTexture = uint32_t(images.size());
            table_.environmentSize = {scene_.environment->texture->width, scene_.environment->texture->height};
            upload(*scene_.environment->texture);
        }
    }
    table_.textures = keep(device_.createBuffer(images, "textures")).address();
}

void SceneGpu::placeInstances(const std::vector<glm::mat4>& pose)
{
    for (const auto& node : scene_.instances) {
        const auto& mesh = scene_.meshes[node.mesh];
        const glm::mat4x3 toWorld(pose[node.node]);
        instances_.push_back(
            {toWorld, mesh.firstTriangle, mesh.triangleCount, INVALID_INDEX, glm::determinant(glm::mat3(toWorld)) < 0});
        previousPoses_.push_back(toWorld);
        meshOfInstance_.push_back(node.mesh);
        bounds_.push_back(boundsOf(meshOfInstance_.size() - 1));
    }
    const Sphere sphere = boundingSphere();
    table_.center = sphere.center;
    table_.radius = sphere.radius;
    table_.instanceCount = uint32_t(instances_.size());
    instanceBuffer_ = device_.createBuffer(instances_, "instances");
    table_.instances = instanceBuffer_.address();
    previousPoseBuffer_ = device_.createBuffer(previousPoses_, "previous poses");
    table_.previousPoses = previousPoseBuffer_.address();
}

Box SceneGpu::boundsOf(size_t instance) const
{
    Box box;
    const auto& mesh = scene_.meshes[meshOfInstance_[instance]];
    for (uint32_t v = 0; v < mesh.vertexCount; ++v)
        box.extend(instances_[instance].objectToWorld * glm::vec4(scene_.positions[mesh.firstVertex + v], 1));
    return box;
}

SceneGpu::Sphere SceneGpu::boundingSphere() const
{
    Box box;
    for (const Box& bounds : bounds_) {
        box.extend(bounds.lower);
        box.extend(bounds.upper);
    }
    return {0.5f * (box.lower + box.upper), std::max(0.5f * glm::distance(box.lower, box.upper), 1e-6f)};
}

/// What kernels measure cells and distances by has to stand still while nodes move: keys of cells and stored paths
/// depend on it. It follows only when the scene has left it, or has shrunk in it; a run begins with the scene's own.
void SceneGpu::followScene(const Sphere& sphere, bool begins)
{
    constexpr float LARGER = 0.5f * POSITION_EXTENT, SMALLER = 0.25f;
    const bool outgrown = glm::distance(sphere.center, table_.center) + sphere.radius > LARGER * table_.radius;
    if (begins || outgrown || sphere.radius < SMALLER * table_.radius) {
        table_.center = sphere.center;
        table_.radius = sphere.radius;
    }
}

void SceneGpu::uploadLights(const std::vector<glm::mat4>& pose)
{
    lights_ = buildLightTable(scene_, pose, boundingSphere().radius);
    for (size_t i = 0; i < instances_.size(); ++i)
        instances_[i].lightMap = lights_.lightMapOfInstance[i];
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    lightBuffer_ = device_.createBuffer(lights_.lights, "lights");
    table_.lights = lightBuffer_.address();
    lightOfTriangleBuffer_ = device_.createBuffer(lights_.lightOfTriangle, "lightOfTriangle");
    table_.lightOfTriangle = lightOfTriangleBuffer_.address();
    table_.lightCount = lights_.lit ? uint32_t(lights_.lights.size()) : 0;
    table_.environmentLight = lights_.environmentLight;
    const auto upload = [&](const std::vector<ImportanceCell>& cells, Buffer& buffer, const char* name) {
        buffer = cells.empty() ? Buffer() : device_.createBuffer(cells, name);
        return cells.empty() ? 0 : buffer.address();
    };
    table_.emissionCells = upload(lights_.emissionCells, emissionCellBuffer_, "emission cells");
    table_.environmentCells = upload(lights_.environmentCells, environmentCellBuffer_, "environment cells");
}

void SceneGpu::refresh()
{
    const Counted counted(device_, bytes_);
    uploadMaterials();
    if (scene_.environment)
        table_.environmentRadiance = scene_.environment->radiance;
    uploadLights(pose_);
}

/// The instances as they stand, and the acceleration structure over them.
void SceneGpu::refreshInstances()
{
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    device_.upload(previousPoseBuffer_, previousPoses_.data(), previousPoses_.size() * sizeof(glm::mat4x3));
    if (software_) {
        software_->update(instances_);
        software_->fill(table_);
        if (software_->isOneLevel() != oneLevel_) {
            oneLevel_ = !oneLevel_;
            device_.changeKernelDefine("RESTIRPG_ONE_LEVEL", oneLevel_ ? "1" : "0");
        }
    } else {
        acceleration_->buildTopLevel(instances_, meshOfInstance_);
        bindings_.setAccelerationStructure(acceleration_->topLevel());
    }
}

/// Move instances, and tell where they were.
void SceneGpu::moveInstances(const std::vector<glm::mat4>& pose, const std::vector<glm::mat4>& previous)
{
    for (size_t i = 0; i < instances_.size(); ++i) {
        auto& instance = instances_[i];
        const uint32_t node = scene_.instances[i].node;
        const glm::mat4x3 toWorld(pose[node]);
        previousPoses_[i] = glm::mat4x3(previous[node]);
        if (instance.objectToWorld == toWorld)
            continue;
        instance.objectToWorld = toWorld;
        instance.flipped = glm::determinant(glm::mat3(toWorld)) < 0;
        bounds_[i] = boundsOf(i);
    }
    refreshInstances();
    previousPose_ = previous;
}

void SceneGpu::update(const std::vector<glm::mat4>& pose, const std::vector<glm::mat4>* before)
{
    const Counted counted(device_, bytes_);
    const auto& previous = before ? *before : pose;
    const bool moved = pose != pose_;
    if (moved || previous != previousPose_)
        moveInstances(pose, previous);
    if (!moved && before)
        return;
    const Sphere sphere = boundingSphere();
    followScene(sphere, !before);
    if (!moved)
        return;
    moveLights(lights_, scene_, pose, sphere.radius);
    table_.lightCount = lights_.lit ? uint32_t(lights_.lights.size()) : 0;
    device_.upload(lightBuffer_, lights_.lights.data(), lights_.lights.size() * sizeof(Light));
    pose_ = pose;
}

}  // namespace restirpg
