#include "trace/rays.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <thread>

namespace restirpg::test {
namespace {

/// Run `body(i)` for i < count on all cores.
template <typename Body>
void parallelFor(size_t count, const Body& body)
{
    const size_t threads = std::max(1u, std::thread::hardware_concurrency());
    std::vector<std::jthread> workers;
    for (size_t thread = 0; thread < threads; ++thread)
        workers.emplace_back([&, thread] {
            for (size_t i = count * thread / threads; i < count * (thread + 1) / threads; ++i)
                body(i);
        });
}

RTCRay toRay(const Ray& ray)
{
    RTCRay r{};
    r.org_x = ray.origin.x, r.org_y = ray.origin.y, r.org_z = ray.origin.z;
    r.dir_x = ray.direction.x, r.dir_y = ray.direction.y, r.dir_z = ray.direction.z;
    r.tfar = ray.length;
    r.mask = 0xffffffff;
    return r;
}

}  // namespace

struct EmbreeScene::Handles {
    RTCDevice device = rtcNewDevice(nullptr);
    RTCScene scene = rtcNewScene(device);
    ~Handles()
    {
        rtcReleaseScene(scene);
        rtcReleaseDevice(device);
    }
};

EmbreeScene::EmbreeScene(const Scene& scene, const std::vector<glm::mat4>& pose) : handles_(std::make_unique<Handles>())
{
    for (uint32_t i = 0; i < scene.instances.size(); ++i) {
        const auto& instance = scene.instances[i];
        const auto& mesh = scene.meshes[instance.mesh];
        RTCGeometry geometry = rtcNewGeometry(handles_->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        auto* vertices = static_cast<glm::vec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, sizeof(glm::vec3), mesh.vertexCount));
        auto* indices = static_cast<glm::uvec3*>(rtcSetNewGeometryBuffer(
            geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, sizeof(glm::uvec3), mesh.triangleCount));
        for (uint32_t v = 0; v < mesh.vertexCount; ++v)
            vertices[v] = glm::vec3(pose[instance.node] * glm::vec4(scene.positions[mesh.firstVertex + v], 1));
        std::copy_n(scene.triangles.begin() + mesh.firstTriangle, mesh.triangleCount, indices);
        rtcCommitGeometry(geometry);
        rtcAttachGeometryByID(handles_->scene, geometry, i);
        rtcReleaseGeometry(geometry);
    }
    rtcSetSceneBuildQuality(handles_->scene, RTC_BUILD_QUALITY_HIGH);
    rtcCommitScene(handles_->scene);
}

EmbreeScene::~EmbreeScene() = default;

std::vector<TracedHit> EmbreeScene::closest(const std::vector<Ray>& rays) const
{
    std::vector<TracedHit> hits(rays.size());
    parallelFor(rays.size(), [&](size_t i) {
        RTCRayHit query{};
        query.ray = toRay(rays[i]);
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(handles_->scene, &query);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(handles_->scene, &context, &query);
#endif
        hits[i] = {{query.hit.geomID, query.hit.primID, {query.hit.u, query.hit.v}}, query.ray.tfar};
    });
    return hits;
}

std::vector<uint8_t> EmbreeScene::occluded(const std::vector<Ray>& rays) const
{
    std::vector<uint8_t> blocked(rays.size());
    parallelFor(rays.size(), [&](size_t i) {
        RTCRay ray = toRay(rays[i]);
#if RTC_VERSION_MAJOR >= 4
        rtcOccluded1(handles_->scene, &ray);
#else
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcOccluded1(handles_->scene, &context, &ray);
#endif
        blocked[i] = ray.tfar < 0;
    });
    return blocked;
}

}  // namespace restirpg::test
