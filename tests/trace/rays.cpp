#include "trace/rays.h"

#include "scene/lights.h"
#include "trace/Shared.h"

#include <cmath>
#include <random>

namespace restirpg::test {
namespace {

/// World corners of a hit triangle.
std::array<glm::vec3, 3> corners(const Scene& scene, const std::vector<glm::mat4>& pose, const Hit& hit)
{
    const auto& instance = scene.instances[hit.instance];
    const auto& mesh = scene.meshes[instance.mesh];
    const auto& triangle = scene.triangles[mesh.firstTriangle + hit.triangle];
    std::array<glm::vec3, 3> p;
    for (int i = 0; i < 3; ++i)
        p[i] = glm::vec3(pose[instance.node] * glm::vec4(scene.positions[mesh.firstVertex + triangle[i]], 1));
    return p;
}

/// The hit point moved a little off its surface towards where the ray came from, and the unit normal on that side.
std::pair<glm::vec3, glm::vec3> leave(const Scene& scene, const std::vector<glm::mat4>& pose, const Ray& ray,
                                      const TracedHit& hit)
{
    const auto p = corners(scene, pose, hit.hit);
    glm::vec3 n = glm::normalize(glm::cross(p[1] - p[0], p[2] - p[0]));
    n = glm::dot(n, ray.direction) > 0 ? -n : n;
    const glm::vec3 x = ray.origin + hit.t * ray.direction;
    return {x + n * (1e-4f * std::max(1.0f, glm::length(x))), n};
}

}  // namespace

DeviceTracer::DeviceTracer(Device& device, const Scene& scene, const std::vector<glm::mat4>& pose)
    : device_(device), scene_(device, scene, pose)
{
    const std::string file = RESTIRPG_SOURCE "/tests/trace/trace_rays.comp";
    closest_ = Kernel(device, file, {{"ANY", "0"}});
    any_ = Kernel(device, file, {{"ANY", "1"}});
    constants_ = device.createBuffer(sizeof(FrameConstants), "frame constants");
    move(pose);
}

void DeviceTracer::move(const std::vector<glm::mat4>& pose)
{
    scene_.update(pose, &pose);
    FrameConstants constants{};
    constants.scene = scene_.table();
    device_.upload(constants_, &constants, sizeof constants);
}

void DeviceTracer::upload(const std::vector<Ray>& rays)
{
    static_assert(sizeof(Ray) == 28 && sizeof(TracedHit) == 20);
    count_ = uint32_t(rays.size());
    rays_ = device_.createBuffer(rays, "rays");
    hits_ = device_.createBuffer(rays.size() * sizeof(TracedHit), "hits");
}

void DeviceTracer::dispatch(const Kernel& kernel)
{
    const TraceRaysParameters parameters{constants_.address(), rays_.address(), hits_.address(), count_};
    device_.submit([&](VkCommandBuffer commands) {
        scene_.bindings().bind(commands);
        kernel.dispatch(commands, &parameters, sizeof parameters, count_);
    });
}

void DeviceTracer::run(bool any)
{
    dispatch(any ? any_ : closest_);
}

std::vector<TracedHit> DeviceTracer::trace(const std::vector<Ray>& rays, const Kernel& kernel)
{
    upload(rays);
    dispatch(kernel);
    return device_.download<TracedHit>(hits_, count_);
}

std::vector<Ray> primaryRays(const Scene& scene, const std::vector<glm::mat4>& pose, uint32_t width, uint32_t height)
{
    const auto& node = scene.cameras[scene.camera];
    const Camera camera = makeCamera(node, pose[node.node], float(width) / float(height));
    std::vector<Ray> rays;
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const float u = 2 * (float(x) + 0.5f) / float(width) - 1, v = 1 - 2 * (float(y) + 0.5f) / float(height);
            rays.push_back({camera.position, glm::normalize(camera.forward + u * camera.right + v * camera.up), 1e30f});
        }
    return rays;
}

std::vector<Ray> bounceRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                            const std::vector<TracedHit>& hits, uint32_t seed)
{
    std::mt19937 generator(seed);
    std::normal_distribution<float> normal;
    std::vector<Ray> bounced;
    for (size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].hit.instance == INVALID_INDEX)
            continue;
        const auto [x, n] = leave(scene, pose, rays[i], hits[i]);
        // A normal plus a uniform point of the sphere is cosine-distributed.
        const glm::vec3 sphere = glm::normalize(glm::vec3(normal(generator), normal(generator), normal(generator)));
        bounced.push_back({x, glm::normalize(n + 0.999f * sphere), 1e30f});
    }
    return bounced;
}

std::vector<Ray> shadowRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                            const std::vector<TracedHit>& hits, uint32_t seed)
{
    std::mt19937 generator(seed);
    std::vector<size_t> found;
    for (size_t i = 0; i < rays.size(); ++i)
        if (hits[i].hit.instance != INVALID_INDEX)
            found.push_back(i);
    std::vector<Ray> shadows;
    for (size_t i : found) {
        const size_t other = found[generator() % found.size()];
        const glm::vec3 x = leave(scene, pose, rays[i], hits[i]).first,
                        y = leave(scene, pose, rays[other], hits[other]).first;
        if (x != y)
            shadows.push_back({x, y - x, 1.0f});
    }
    return shadows;
}

std::vector<Ray> lightRays(const Scene& scene, const std::vector<glm::mat4>& pose, const std::vector<Ray>& rays,
                           const std::vector<TracedHit>& hits, uint32_t seed)
{
    constexpr float JUST_BEFORE = 0.999f;
    std::vector<Light> emitters;
    std::vector<double> powers;
    for (const Light& light : buildLightTable(scene, pose, 1).lights)
        if (light.type == LIGHT_TRIANGLE) {
            emitters.push_back(light);
            powers.push_back(light.pmf);
        }
    std::vector<Ray> shadows;
    if (emitters.empty())
        return shadows;
    std::mt19937 generator(seed);
    std::discrete_distribution<size_t> select(powers.begin(), powers.end());
    std::uniform_real_distribution<float> uniform;
    for (size_t i = 0; i < rays.size(); ++i) {
        if (hits[i].hit.instance == INVALID_INDEX)
            continue;
        const Light& light = emitters[select(generator)];
        const auto p = corners(scene, pose, Hit{light.instance, light.triangle, {}});
        const float r = std::sqrt(uniform(generator)), b = uniform(generator) * r;
        const glm::vec3 x = leave(scene, pose, rays[i], hits[i]).first, y = (1 - r) * p[0] + (r - b) * p[1] + b * p[2];
        shadows.push_back({x, JUST_BEFORE * (y - x), 1.0f});
    }
    return shadows;
}

}  // namespace restirpg::test
