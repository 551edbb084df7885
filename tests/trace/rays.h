// Batches of rays, traced by the device's back end and by Embree on the CPU. Tests compare hits; benchmarks compare
// rates.
#pragma once

#include "gpu/kernel.h"
#include "render/scene_gpu.h"
#include "scene/scene.h"

#include <memory>
#include <vector>

namespace restirpg::test {

struct Ray {
    glm::vec3 origin;
    glm::vec3 direction;
    float length;  ///< in units of the direction
};

struct TracedHit {
    Hit hit;
    float t;
};

/// Embree over the scene's triangles in world space, one geometry an instance.
class EmbreeScene {
public:
    EmbreeScene(const Scene& scene, const std::vector<glm::mat4>& pose);
    ~EmbreeScene();
    EmbreeScene(const EmbreeScene&) = delete;
    EmbreeScene& operator=(const EmbreeScene&) = delete;

    /// Single-ray queries, on all cores.
    std::vector<TracedHit> closest(const std::vector<Ray>& rays) const;
    std::vector<uint8_t> occluded(const std::vector<Ray>& rays) const;

private:
    struct Handles;
    std::unique_ptr<Handles> handles_;
};

/// The kernels' back end.
class DeviceTracer {
public:
    DeviceTracer(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose);

    std::vector<TracedHit> closest(const std::vector<Ray>& rays) { return trace(rays, closest_); }
    /// hit.instance is INVALID_INDEX where nothing is in the way.
    std::vector<TracedHit> any(const std::vector<Ray>& rays) { return trace(rays, any_); }

    /// Follow the nodes to a new pose.
    void move(const std::vector<glm::mat4>& pose);

    /// Upload rays once, then trace them again and again: for benchmarks.
    void upload(const std::vector<Ray>& rays);
    void run(bool any);

private:
    std::vector<TracedHit> trace(const std::vector<Ray>& rays, const Kernel& kernel);
    void dispatch(const Kernel& kernel);

    Device& device_;
    SceneGpu scene_;
    Kernel closest_, any_;
    Buffer constants_, rays_, hits_;
    uint32_t count_ = 0;
};

/// Primary rays through the pixel centres of the scene's camera.
std::vector<Ray> primaryRays(const Scene& scene, const std::vector<glm::mat4>& pose, uint32_t width, uint32_t height);
/// From where `rays` hit, cosine-distributed about the normal on the ray's side. Deterministic in `seed`.
std::vector<Ray> bounceRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                            const std::vector<TracedHit>& hits, uint32_t seed);
/// From where `rays` hit to where other ones did, at random, up to just before the point.
std::vector<Ray> shadowRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                            const std::vector<TracedHit>& hits, uint32_t seed);
/// From where `rays` hit to points of emissive triangles, as next event estimation has them: by power, uniform over the
/// triangle, up to just before the point. Empty when no triangle emits.
std::vector<Ray> lightRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                           const std::vector<TracedHit>& hits, uint32_t seed);

}  // namespace restirpg::test
