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

/// The world box of a mesh's box.
Box transformBox(const Box& box, const glm::mat4x3& toWorld)
{
    Box world;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(corner & 1 ? box.upper.x : box.lower.x, corner & 2 ? box.upper.y : box.lower.y,
                          corner & 4 ? box.upper.z : box.lower.z);
        world.extend(toWorld * glm::vec4(p, 1));
    }
    return world;
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
    buildTopLevel();
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
    const bool software = device_.backend() == Backend::software;
    std::vector<AccelerationMesh> structures;
    for (const auto& mesh : scene_.meshes) {
        MeshGpu gpu;
        const std::span positions(scene_.positions.data() + mesh.firstVertex, mesh.vertexCount);
        const std::span triangles(scene_.triangles.data() + mesh.firstTriangle, mesh.triangleCount);
        for (const auto& triangle : triangles)
            for (int corner = 0; corner < 3; ++corner)
                gpu.bounds.extend(positions[triangle[corner]]);
        const bool masked = std::any_of(
            scene_.materialOfTriangle.begin() + mesh.firstTriangle,
            scene_.materialOfTriangle.begin() + mesh.firstTriangle + mesh.triangleCount,
            [&](uint32_t material) { return scene_.materials[material].flags & MATERIAL_ALPHA_MASK; });
        if (software) {
            const auto bvh = buildTriangleBvh(positions, triangles);
            gpu.nodes = device_.createBuffer(bvh.nodes, "BVH nodes");
            gpu.triangles = device_.createBuffer(bvh.triangles, "BVH triangles");
        }
        structures.push_back({table_.positions + mesh.firstVertex * sizeof(glm::vec3),
                              table_.indices + mesh.firstTriangle * sizeof(glm::uvec3), mesh.vertexCount,
                              mesh.triangleCount, !masked});
        meshTable_.push_back({gpu.nodes.address(), gpu.triangles.address(), mesh.firstTriangle, mesh.triangleCount,
                              mesh.firstVertex, masked ? MESH_HAS_ALPHA_MASK : 0});
        meshes_.push_back(std::move(gpu));
    }
    meshBuffer_ = device_.createBuffer(meshTable_, "meshes");
    table_.meshes = meshBuffer_.address();
    if (!software)
        acceleration_ = std::make_unique<AccelerationStructures>(device_, structures);
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
    Box world;
    for (const auto& node : scene_.instances) {
        Instance instance{};
        instance.mesh = node.mesh;
        instance.node = node.node;
        instance.lightMap = INVALID_INDEX;
        instance.objectToWorld = instance.previousObjectToWorld = glm::mat4x3(pose[node.node]);
        instances_.push_back(instance);
        const Box box = transformBox(meshes_[node.mesh].bounds, instance.objectToWorld);
        world.extend(box.lower);
        world.extend(box.upper);
    }
    // The bounding sphere of the first pose. It scales light powers and cell sizes, which have to stand still while nodes move.
    table_.center = 0.5f * (world.lower + world.upper);
    table_.radius = std::max(0.5f * glm::distance(world.lower, world.upper), 1e-6f);
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

/// The world's hierarchy over the instances as they stand, and their inverse matrices.
void SceneGpu::buildTopLevel()
{
    for (auto& instance : instances_) {
        const glm::mat4 toWorld(instance.objectToWorld);
        instance.worldToObject = glm::mat4x3(glm::inverse(toWorld));
        instance.flipped = glm::determinant(glm::mat3(toWorld)) < 0;
    }
    device_.upload(instanceBuffer_, instances_.data(), instances_.size() * sizeof(Instance));
    if (acceleration_) {
        acceleration_->buildTopLevel(instances_);
        bindings_->setAccelerationStructure(acceleration_->topLevel());
        return;
    }
    std::vector<Box> boxes;
    for (const auto& instance : instances_)
        boxes.push_back(transformBox(meshes_[instance.mesh].bounds, instance.objectToWorld));
    const Bvh bvh = buildBvh(boxes, 1);
    const auto put = [&](Buffer& buffer, const auto& contents, const char* name) {
        if (buffer.bytes() < contents.size() * sizeof(contents[0]))
            buffer = device_.createBuffer(contents, name);
        else
            device_.upload(buffer, contents.data(), contents.size() * sizeof(contents[0]));
    };
    put(tlasNodes_, bvh.nodes, "TLAS nodes");
    put(tlasInstances_, bvh.order, "TLAS instances");
    table_.tlasNodes = tlasNodes_.address();
    table_.tlasInstances = tlasInstances_.address();
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
    buildTopLevel();
    if (moved) {
        moveLights(lights_, scene_, pose);
        device_.upload(lightBuffer_, lights_.lights.data(), lights_.lights.size() * sizeof(Light));
        pose_ = pose;
    }
    settled_ = !moved;
}

}  // namespace restirpg
