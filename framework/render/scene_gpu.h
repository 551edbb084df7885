// The scene in device memory: geometry, materials, textures, lights and the back end's acceleration structures.
#pragma once

#include "gpu/accel.h"
#include "gpu/binding_set.h"
#include "gpu/bvh.h"
#include "render/software_tracing.h"
#include "scene/lights.h"
#include "scene/scene.h"
#include "shaders/frame_types.h"

#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace restirpg {

class SceneGpu {
public:
    /// Upload the scene as it stands at `pose` (world matrices, in the order of Scene::nodes). With energy
    /// compensation, kernels built from now on give rough surfaces the light back that single scattering loses.
    SceneGpu(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose, bool energyCompensation = false);

    /// Take materials, lights and the environment's radiance as the scene has them now, at the pose of the last update.
    /// The light table is made anew, so that lights may get other indices: history that refers to them is to be cut.
    void refresh();

    /// Move instances and lights to a new pose and bring the acceleration structure up to date, before every frame.
    /// `before`: the pose of the frame before; null: the frame is the first one of a run, and nothing has moved.
    void update(const std::vector<glm::mat4>& pose, const std::vector<glm::mat4>* before);

    const SceneTable& table() const { return table_; }
    const BindingSet& bindings() const { return bindings_; }
    const LightTable& lights() const { return lights_; }
    uint64_t bytes() const { return bytes_; }

private:
    struct Sphere {
        glm::vec3 center;
        float radius;
    };
    void uploadGeometry();
    void uploadEnergyTables();
    void uploadMaterials();
    void createAcceleration();
    void uploadTextures();
    void placeInstances(const std::vector<glm::mat4>& pose);
    Box boundsOf(size_t instance) const;
    Sphere boundingSphere() const;
    void followScene(const Sphere& sphere, bool begins);
    void uploadLights(const std::vector<glm::mat4>& pose);
    void moveInstances(const std::vector<glm::mat4>& pose, const std::vector<glm::mat4>& previous);
    void refreshInstances();
    Buffer& keep(Buffer buffer);

    Device& device_;
    const Scene& scene_;
    SceneTable table_{};
    std::vector<Buffer> buffers_;
    std::vector<Instance> instances_;
    std::vector<glm::mat4x3> previousPoses_;
    std::vector<uint32_t> meshOfInstance_;
    std::vector<Box> bounds_;  ///< of each instance, world space
    LightTable lights_;
    std::vector<glm::mat4> pose_, previousPose_;  ///< on the device
    std::map<float, uint32_t> energyTableOf_;  ///< by index of refraction; empty: no energy compensation
    Buffer instanceBuffer_, previousPoseBuffer_, materialBuffer_;
    Buffer lightBuffer_, lightOfTriangleBuffer_, emissionCellBuffer_, environmentCellBuffer_;
    BindingSet bindings_;
    std::unique_ptr<SoftwareTracing> software_;
    bool oneLevel_ = false;  ///< what kernels were told
    std::unique_ptr<AccelerationStructures> acceleration_;
    uint64_t bytes_ = 0;
};

}  // namespace restirpg
