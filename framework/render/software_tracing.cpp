#include "render/software_tracing.h"

#include <algorithm>

namespace restirpg {
namespace {

/// Copies of shared meshes that may join the static batch, triangles: some 20 MB.
constexpr uint64_t COPIED_TRIANGLES = 200'000;

/// The world box of an object's box, rounded outwards.
Box transformBox(const Box& box, const glm::mat4x3& toWorld)
{
    Box world;
    for (int corner = 0; corner < 8; ++corner) {
        const glm::vec3 p(glm::dmat4x3(toWorld) * glm::dvec4(corner & 1 ? box.upper.x : box.lower.x,
                                                             corner & 2 ? box.upper.y : box.lower.y,
                                                             corner & 4 ? box.upper.z : box.lower.z, 1));
        const glm::vec3 rounding = 0x1p-23f * glm::abs(p);
        world.extend(p - rounding);
        world.extend(p + rounding);
    }
    return world;
}

template <typename Range>
void put(Device& device, Buffer& buffer, const Range& contents, const char* name)
{
    const uint64_t bytes = contents.size() * sizeof(contents[0]);
    if (buffer.bytes() < bytes)
        buffer = device.createBuffer(contents, name);
    else
        device.upload(buffer, contents.data(), bytes);
}

}  // namespace

SoftwareTracing::SoftwareTracing(Device& device, const Scene& scene, std::span<const Instance> instances)
    : device_(device), scene_(scene), meshes_(scene.meshes.size()), batched_(instances.size()),
      batchPose_(instances.size())
{
    std::vector<uint32_t> uses(scene.meshes.size());
    for (const auto& instance : scene.instances)
        ++uses[instance.mesh];
    const auto animated = animatedNodes(scene);
    uint64_t copied = 0;
    for (size_t i = 0; i < instances.size(); ++i)
        if (uses[scene.instances[i].mesh] > 1 && !animated[scene.instances[i].node])
            copied += scene.meshes[scene.instances[i].mesh].triangleCount;
    for (size_t i = 0; i < instances.size(); ++i)
        batched_[i] =
            (uses[scene.instances[i].mesh] == 1 || copied <= COPIED_TRIANGLES) && !animated[scene.instances[i].node];
    buildBatch(instances);
    update(instances);
}

void SoftwareTracing::appendTriangles(std::vector<SourceTriangle>& triangles, uint32_t mesh, uint32_t instance,
                                      const glm::mat4x3& toTarget) const
{
    const glm::dmat4x3 exact(toTarget);  // corners are rounded once: find_clearance of triangle.glsl counts on it
    const auto& range = scene_.meshes[mesh];
    for (uint32_t i = 0; i < range.triangleCount; ++i) {
        const auto& index = scene_.triangles[range.firstTriangle + i];
        auto& triangle = triangles.emplace_back(SourceTriangle{{}, instance, i});
        for (int corner = 0; corner < 3; ++corner)
            triangle.corners[corner] = exact * glm::dvec4(scene_.positions[range.firstVertex + index[corner]], 1);
    }
}

SoftwareTracing::Hierarchy SoftwareTracing::build(std::span<const SourceTriangle> triangles, const std::string& name)
{
    const auto bvh = buildTriangleBvh(triangles);
    Hierarchy hierarchy{device_.createBuffer(bvh.nodes, name + " nodes"),
                        device_.createBuffer(bvh.triangles, name + " triangles"),
                        bvh.grid,
                        {}};
    for (const auto& triangle : triangles)
        for (const auto& corner : triangle.corners)
            hierarchy.bounds.extend(corner);
    return hierarchy;
}

bool SoftwareTracing::isMasked(uint32_t mesh) const
{
    const auto first = scene_.materialOfTriangle.begin() + scene_.meshes[mesh].firstTriangle;
    return std::any_of(first, first + scene_.meshes[mesh].triangleCount,
                       [&](uint32_t material) { return scene_.materials[material].flags & MATERIAL_ALPHA_MASK; });
}

void SoftwareTracing::buildBatch(std::span<const Instance> instances)
{
    std::vector<SourceTriangle> triangles;
    batchMasked_ = false;
    for (uint32_t i = 0; i < instances.size(); ++i) {
        batchPose_[i] = instances[i].objectToWorld;
        if (!batched_[i])
            continue;
        const uint32_t mesh = scene_.instances[i].mesh;
        appendTriangles(triangles, mesh, i, instances[i].objectToWorld);
        batchMasked_ = batchMasked_ || isMasked(mesh);
    }
    batch_ = triangles.empty() ? Hierarchy{} : build(triangles, "static batch");
}

void SoftwareTracing::update(std::span<const Instance> instances)
{
    bool left = false;
    for (size_t i = 0; i < instances.size(); ++i)
        if (batched_[i] && batchPose_[i] != instances[i].objectToWorld) {
            batched_[i] = false;
            left = true;
        }
    if (left)
        buildBatch(instances);

    std::vector<BvhObject> objects;
    std::vector<Box> boxes;
    if (batch_.nodes) {
        objects.push_back({batch_.nodes.address(), batch_.triangles.address(), glm::mat4x3(1), batch_.grid,
                           INVALID_INDEX, batchMasked_});
        boxes.push_back(batch_.bounds);
    }
    for (uint32_t i = 0; i < instances.size(); ++i) {
        if (batched_[i])
            continue;
        const glm::mat4x3& toWorld = instances[i].objectToWorld;
        const uint32_t index = scene_.instances[i].mesh;
        auto& mesh = meshes_[index];
        if (!mesh.nodes) {
            std::vector<SourceTriangle> triangles;
            appendTriangles(triangles, index, i, glm::mat4x3(1));
            mesh = build(triangles, "mesh");
        }
        // In double: rays must not miss by the error of the inverse.
        glm::mat4x3 toObject(glm::inverse(glm::dmat4(glm::mat4(toWorld))));
        toObject[3] = toWorld[3];  // trace_software.glsl says why
        objects.push_back({mesh.nodes.address(), mesh.triangles.address(), toObject, mesh.grid, i, isMasked(index)});
        boxes.push_back(transformBox(mesh.bounds, toWorld));
    }
    const Bvh top = buildBvh(boxes, 1);
    std::vector<BvhObject> ordered;
    for (uint32_t i : top.order)
        ordered.push_back(objects[i]);
    topGrid_ = top.grid;
    put(device_, topNodes_, top.nodes, "TLAS nodes");
    put(device_, objects_, ordered, "TLAS objects");
}

bool SoftwareTracing::isOneLevel() const
{
    return std::find(batched_.begin(), batched_.end(), false) == batched_.end();
}

void SoftwareTracing::fill(SceneTable& table) const
{
    table.tlasNodes = topNodes_.address();
    table.bvhObjects = objects_.address();
    table.tlasGrid = topGrid_;
}

}  // namespace restirpg
