#include "render/scene_gpu.h"

#include "core/error.h"

#include <algorithm>

namespace restirpg {
namespace {

VkSamplerAddressMode addressMode(Texture::Wrap wrap)
{
    switch (wrap) {
    case Texture::Wrap::mirroredRepeat: return VK_SAMPLER_ADDRESS_MODE_MIRRORED_REPEAT;
    case Texture::Wrap::clampToEdge: return VK_SAMPLER_ADDRESS_MODE_CLAMP_TO_EDGE;
    default: return VK_SAMPLER_ADDRESS_MODE_REPEAT;
    }
}

TextureSource toSource(const Texture& texture)
{
    TextureSource source;
    source.name = texture.name;
    source.width = texture.width;
    source.height = texture.height;
    source.srgb = texture.srgb;
    source.bytes = texture.bytes;
    source.floats = texture.floats;
    source.wrapU = addressMode(texture.wrapU);
    source.wrapV = addressMode(texture.wrapV);
    source.filter = texture.filter == Texture::Filter::nearest ? VK_FILTER_NEAREST : VK_FILTER_LINEAR;
    return source;
}

bool hasAlphaMask(const Scene& scene)
{
    return std::any_of(scene.materials.begin(), scene.materials.end(),
                       [](const Material& material) { return material.flags & MATERIAL_ALPHA_MASK; });
}

}  // namespace

SceneGpu::SceneGpu(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose) : device_(device), scene_(scene)
{
    const uint64_t before = device.allocatedBytes();
    device.setKernelDefine("RESTIRPG_ALPHA_MASK", hasAlphaMask(scene) ? "1" : "0");
    uploadGeometry();
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
    table_.materials = keep(device_.createBuffer(scene_.materials, "materials")).address();
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
    std::vector<TextureSource> sources;
    for (const auto& texture : scene_.textures)
        sources.push_back(toSource(texture));
    table_.environmentTexture = INVALID_INDEX;
    if (scene_.environment) {
        table_.environmentRadiance = scene_.environment->radiance;
        table_.environmentRotation = scene_.environment->rotation;
        if (scene_.environment->texture) {
            table_.environmentTexture = uint32_t(sources.size());
            table_.environmentSize = {scene_.environment->texture->width, scene_.environment->texture->height};
            sources.push_back(toSource(*scene_.environment->texture));
        }
    }
    bindings_ = std::make_unique<BindingSet>(device_, sources);
}

void SceneGpu::placeInstances(const std::vector<glm::mat4>& pose)
{
    glm::vec3 lower(1e30f), upper(-1e30f);
    for (const auto& node : scene_.instances) {
        Instance instance{};
        instance.mesh = node.mesh;
        instance.node = node.node;
        instance.lightMap = INVALID_INDEX;
        instance.objectToWorld = instance.previousObjectToWorld = glm::mat4x3(pose[node.node]);
        instance.worldToObject = glm::mat4x3(glm::inverse(pose[node.node]));
        instances_.push_back(instance);
        const auto& mesh = scene_.meshes[node.mesh];
        for (uint32_t v = 0; v < mesh.vertexCount; ++v) {
            const glm::vec3 p = instance.objectToWorld * glm::vec4(scene_.positions[mesh.firstVertex + v], 1);
            lower = glm::min(lower, p);
            upper = glm::max(upper, p);
        }
    }
    // The bounding sphere of the first pose. It scales light powers and cell sizes, which have to stand still while nodes move.
    table_.center = 0.5f * (lower + upper);
    table_.radius = std::max(0.5f * glm::distance(lower, upper), 1e-6f);
    table_.instanceCount = uint32_t(instances_.size());
    instanceBuffer_ = device_.createBuffer(instances_, "instances");
    table_.instances = instanceBuffer_.address();
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
    table_.lightCount = uint32_t(lights_.lights.size());
    table_.environmentLight = lights_.environmentLight;
    if (!lights_.environmentCells.empty())
        table_.environmentCells = keep(device_.createBuffer(lights_.environmentCells, "environment cells")).address();
}

/// Inverse matrices, and the acceleration structure over the instances as they stand.
void SceneGpu::refreshInstances()
{
    for (auto& instance : instances_) {
        const glm::mat4 toWorld(instance.objectToWorld);
        instance.worldToObject = glm::mat4x3(glm::inverse(toWorld));
        instance.flipped = glm::determinant(glm::mat3(toWorld)) < 0;
    }
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    if (software_) {
        software_->update(instances_);
        software_->fill(table_);
    } else {
        acceleration_->buildTopLevel(instances_);
        bindings_->setAccelerationStructure(acceleration_->topLevel());
    }
}

void SceneGpu::update(const std::vector<glm::mat4>& pose)
{
    const bool moved = pose != pose_;
    if (!moved && settled_)
        return;
    for (size_t i = 0; i < instances_.size(); ++i) {
        instances_[i].previousObjectToWorld = instances_[i].objectToWorld;
        instances_[i].objectToWorld = glm::mat4x3(pose[scene_.instances[i].node]);
    }
    refreshInstances();
    if (moved) {
        moveLights(lights_, scene_, pose);
        device_.upload(lightBuffer_, lights_.lights.data(), lights_.lights.size() * sizeof(Light));
        pose_ = pose;
    }
    settled_ = !moved;
}

}  // namespace restirpg
