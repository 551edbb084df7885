// The software back end's acceleration structure: a top level over one static batch and the objects that move.
#pragma once

#include "gpu/bvh.h"
#include "gpu/device.h"
#include "scene/scene.h"

#include <span>
#include <vector>

namespace restirpg {

/// Everything that stands still is one hierarchy in world space: rays enter one tree instead of many that overlap
/// (benchmarks/results/tracing_rates). Instances that share a mesh keep its own hierarchy where copies would take
/// much memory. An instance that moves for the first time leaves the batch, which is built again without it. Hits are
/// the same either way.
class SoftwareTracing {
public:
    SoftwareTracing(Device& device, const Scene& scene, std::span<const Instance> instances);

    /// Follow the instances' matrices.
    void update(std::span<const Instance> instances);
    void fill(SceneTable& table) const;
    /// Is everything in the static batch, so that kernels need no second level (RESTIRPG_ONE_LEVEL)?
    bool isOneLevel() const;

private:
    struct Hierarchy {
        Buffer nodes;
        Buffer triangles;
        BvhGrid grid{};
        Box bounds;
    };
    Hierarchy build(std::span<const SourceTriangle> triangles, const std::string& name);
    void buildBatch(std::span<const Instance> instances);
    void appendTriangles(std::vector<SourceTriangle>& triangles, uint32_t mesh, uint32_t instance,
                         const glm::mat4x3& toTarget) const;
    bool isMasked(uint32_t mesh) const;

    Device& device_;
    const Scene& scene_;
    std::vector<Hierarchy> meshes_;  ///< built when an instance of the mesh first needs it
    Hierarchy batch_;
    bool batchMasked_ = false;
    std::vector<bool> batched_;  ///< per instance
    std::vector<glm::mat4x3> batchPose_;
    BvhGrid topGrid_{};
    Buffer topNodes_, objects_;
};

}  // namespace restirpg
