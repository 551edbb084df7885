#include "render/scene_gpu.h"

#include "core/error.h"
#include "scene/energy_table.h"
#include "shaders/path_vertex_types.h"

#include <algorithm>
#include <map>

namespace restirpg {
namespace {

uint32_t wrapMode(Texture::Wrap wrap)
{
    switch (wrap) {
    case Texture::Wrap::mirroredRepeat: return TEXTURE_MIRROR;
    case Texture::Wrap::clampToEdge: return TEXTURE_CLAMP;
    default: return TEXTURE_REPEAT;
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

bool hasAlphaMask(const Scene& scene)
{
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& material) { return material.flags & MATERIAL_ALPHA_MASK; });
}

}  // namespace

SceneGpu::SceneGpu(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose, bool energyCompensation)
    : device_(device), scene_(scene), bindings_(device)
{
    const uint64_t before = device.allocatedBytes();
    device.setKernelDefine("RESTIRPG_ALPHA_MASK", hasAlphaMask(scene) ? "1" : "0");
    uploadGeometry();
    uploadMaterials(energyCompensation);
    uploadMeshes();
    uploadTextures();
    placeInstances(pose);
    createAcceleration();
    refreshInstances();
    uploadLights(pose);
    pose_ = pose;
    bytes_ = device.allocatedBytes() - before;
}

Buffer& SceneGpu::keep(Buffer buffer)
{
    return buffers_.emplace_back(std::move(buffer));
}

void SceneGpu::uploadGeometry()
{
    table_.positions = keep(device_.createBuffer(scene_.positions, "positions")).address();
    table_.attributes = keep(device_.createBuffer(scene_.attributes, "attributes")).address();
    table_.indices = keep(device_.createBuffer(scene_.triangles, "indices")).address();
    table_.materialOfTriangle = keep(device_.createBuffer(scene_.materialOfTriangle, "materialOfTriangle")).address();
}

/// The materials; with energy compensation one table for each index of refraction that they have.
void SceneGpu::uploadMaterials(bool energyCompensation)
{
    std::vector<Material> materials = scene_.materials;
    if (energyCompensation) {
        device_.setKernelDefine("RESTIRPG_ENERGY_COMPENSATION", "1");
        std::map<float, uint32_t> indices;
        std::vector<glm::vec4> tables;
        for (Material& material : materials) {
            const auto [found, added] = indices.try_emplace(material.ior, uint32_t(indices.size()));
            material.energyTable = found->second;
            if (!added)
                continue;
            const auto table = energyTable(material.ior);
            tables.insert(tables.end(), table.begin(), table.end());
        }
        table_.energyTables = keep(device_.createBuffer(tables, "energy tables")).address();
    }
    table_.materials = keep(device_.createBuffer(materials, "materials")).address();
}

void SceneGpu::uploadMeshes()
{
    std::vector<Mesh> meshes;
    for (const auto& mesh : scene_.meshes)
        meshes.push_back({mesh.firstTriangle, mesh.triangleCount, mesh.firstVertex});
    table_.meshes = keep(device_.createBuffer(meshes, "meshes")).address();
}

void SceneGpu::createAcceleration()
{
    if (device_.backend() == Backend::software) {
        software_ = std::make_unique<SoftwareTracing>(device_, scene_, instances_);
        return;
    }
    std::vector<AccelerationMesh> meshes;
    for (const auto& mesh : scene_.meshes) {
        const auto first = scene_.materialOfTriangle.begin() + mesh.firstTriangle;
        const bool masked = std::any_of(first, first + mesh.triangleCount, [&](uint32_t material) {
            return scene_.materials[material].flags & MATERIAL_ALPHA_MASK;
        });
        meshes.push_back({table_.positions + mesh.firstVertex * sizeof(glm::vec3),
                          table_.indices + mesh.firstTriangle * sizeof(glm::uvec3), mesh.vertexCount, mesh.triangleCount,
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
        Instance instance{};
        instance.mesh = node.mesh;
        instance.node = node.node;
        instance.lightMap = INVALID_INDEX;
        instance.objectToWorld = instance.previousObjectToWorld = glm::mat4x3(pose[node.node]);
        instances_.push_back(instance);
        bounds_.push_back(boundsOf(instance));
    }
    const Sphere sphere = boundingSphere();
    table_.center = sphere.center;
    table_.radius = sphere.radius;
    table_.instanceCount = uint32_t(instances_.size());
    instanceBuffer_ = device_.createBuffer(instances_, "instances");
    table_.instances = instanceBuffer_.address();
}

Box SceneGpu::boundsOf(const Instance& instance) const
{
    Box box;
    const auto& mesh = scene_.meshes[instance.mesh];
    for (uint32_t v = 0; v < mesh.vertexCount; ++v)
        box.extend(instance.objectToWorld * glm::vec4(scene_.positions[mesh.firstVertex + v], 1));
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

/// What kernels measure cells and distances by has to stand still while nodes move: keys of cells and stored paths depend on it. It
/// follows only when the scene has left it, or has shrunk in it.
void SceneGpu::followScene(const Sphere& sphere)
{
    constexpr float LARGER = 0.5f * POSITION_EXTENT, SMALLER = 0.25f;
    const bool outgrown = glm::distance(sphere.center, table_.center) + sphere.radius > LARGER * table_.radius;
    if (outgrown || sphere.radius < SMALLER * table_.radius) {
        table_.center = sphere.center;
        table_.radius = sphere.radius;
    }
}

void SceneGpu::uploadLights(const std::vector<glm::mat4>& pose)
{
    lights_ = buildLightTable(scene_, pose, table_.radius);
    for (size_t i = 0; i < instances_.size(); ++i)
        instances_[i].lightMap = lights_.lightMapOfInstance[i];
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    lightBuffer_ = device_.createBuffer(lights_.lights, "lights");
    table_.lights = lightBuffer_.address();
    table_.lightOfTriangle = keep(device_.createBuffer(lights_.lightOfTriangle, "lightOfTriangle")).address();
    table_.lightCount = lights_.lit ? uint32_t(lights_.lights.size()) : 0;
    table_.environmentLight = lights_.environmentLight;
    if (!lights_.emissionCells.empty())
        table_.emissionCells = keep(device_.createBuffer(lights_.emissionCells, "emission cells")).address();
    if (!lights_.environmentCells.empty())
        table_.environmentCells = keep(device_.createBuffer(lights_.environmentCells, "environment cells")).address();
}

/// Inverse matrices, and the acceleration structure over the instances as they stand.
void SceneGpu::refreshInstances()
{
    for (auto& instance : instances_) {
        const glm::mat4 toWorld(instance.objectToWorld);
        // In double: rays must not miss by the error of the inverse.
        instance.worldToObject = glm::mat4x3(glm::inverse(glm::dmat4(toWorld)));
        instance.flipped = glm::determinant(glm::mat3(toWorld)) < 0;
    }
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    if (software_) {
        software_->update(instances_);
        software_->fill(table_);
    } else {
        acceleration_->buildTopLevel(instances_);
        bindings_.setAccelerationStructure(acceleration_->topLevel());
    }
}

void SceneGpu::update(const std::vector<glm::mat4>& pose)
{
    const bool moved = pose != pose_;
    if (!moved && settled_)
        return;
    for (size_t i = 0; i < instances_.size(); ++i) {
        auto& instance = instances_[i];
        instance.previousObjectToWorld = instance.objectToWorld;
        instance.objectToWorld = glm::mat4x3(pose[scene_.instances[i].node]);
        if (instance.objectToWorld != instance.previousObjectToWorld)
            bounds_[i] = boundsOf(instance);
    }
    refreshInstances();
    if (moved) {
        const Sphere sphere = boundingSphere();
        followScene(sphere);
        moveLights(lights_, scene_, pose, sphere.radius);
        table_.lightCount = lights_.lit ? uint32_t(lights_.lights.size()) : 0;
        device_.upload(lightBuffer_, lights_.lights.data(), lights_.lights.size() * sizeof(Light));
        pose_ = pose;
    }
    settled_ = !moved;
}

}  // namespace restirpg
