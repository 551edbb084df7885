#include "cases.h"

#include "trace/rays.h"

#include <fmt/format.h>

#include <chrono>
#include <map>

namespace restirpg::bench {
namespace {

using test::DeviceTracer;
using test::EmbreeScene;
using test::Ray;

constexpr uint32_t WIDTH = 640, HEIGHT = 360;  ///< of the primary rays, as in the project's earlier measurements

/// shadow: between random hits; light: to points of emitters.
enum class Kind { primary, bounce, shadow, light };
constexpr std::pair<Kind, const char*> KINDS[] = {
    {Kind::primary, "primary"}, {Kind::bounce, "bounce"}, {Kind::shadow, "shadow"}, {Kind::light, "light"}};

/// Is it enough to know that something is in the way?
bool wantsAnyHit(Kind kind)
{
    return kind == Kind::shadow || kind == Kind::light;
}

/// A scene's rays, all found with Embree so that every tracer gets the same.
struct Workload {
    std::shared_ptr<const Scene> scene;
    std::vector<glm::mat4> pose;
    EmbreeScene embree;
    std::map<Kind, std::vector<Ray>> rays;

    explicit Workload(const std::string& file)
        : scene(loadScene(file)), pose(poseNodes(*scene, 0)), embree(*scene, pose)
    {
        rays[Kind::primary] = test::primaryRays(*scene, pose, WIDTH, HEIGHT);
        const auto hits = embree.closest(rays[Kind::primary]);
        rays[Kind::bounce] = test::bounceRays(*scene, pose, rays[Kind::primary], hits, 1);
        rays[Kind::shadow] = test::shadowRays(*scene, pose, rays[Kind::primary], hits, 2);
        rays[Kind::light] = test::lightRays(*scene, pose, rays[Kind::primary], hits, 3);
    }
};

struct Traced {
    Device device;
    DeviceTracer tracer;

    Traced(const DeviceOptions& options, const Workload& workload)
        : device(options), tracer(device, *workload.scene, workload.pose)
    {
    }
};

Workload& workloadOf(const std::string& scene)
{
    static Kept kept;  // of the host alone
    return keep<Workload>(kept, scene, [&] { return std::make_shared<Workload>(scene); });
}

/// Time `trace()`, host side: it returns when the rays are done.
template <typename Trace>
void timeRays(benchmark::State& state, size_t count, const Trace& trace)
{
    using Clock = std::chrono::steady_clock;
    for (auto _ : state) {
        const auto start = Clock::now();
        trace();
        state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start).count());
    }
    state.counters["rays/s"] = benchmark::Counter(double(count), benchmark::Counter::kIsIterationInvariantRate);
}

void runEmbree(benchmark::State& state, const std::string& scene, Kind kind)
{
    auto& workload = workloadOf(scene);
    const auto& rays = workload.rays[kind];
    if (rays.empty())
        return state.SkipWithError("no triangle emits");
    timeRays(state, rays.size(), [&] {
        if (wantsAnyHit(kind))
            benchmark::DoNotOptimize(workload.embree.occluded(rays));
        else
            benchmark::DoNotOptimize(workload.embree.closest(rays));
    });
}

void runDevice(benchmark::State& state, const std::string& scene, const DeviceOptions& options, Kind kind)
{
    auto& workload = workloadOf(scene);
    auto& traced = keep<Traced>(onDevice(), "trace\n" + scene + options.backend,
                                [&] { return std::make_shared<Traced>(options, workload); });
    const auto& rays = workload.rays[kind];
    if (rays.empty())
        return state.SkipWithError("no triangle emits");
    traced.tracer.upload(rays);
    traced.tracer.run(wantsAnyHit(kind));  // compiles the kernel
    timeRays(state, rays.size(), [&] { traced.tracer.run(wantsAnyHit(kind)); });
}

}  // namespace

void registerTracing(const Cases& cases)
{
    const auto names = namesOf(cases.scenes);
    for (const auto& scene : cases.scenes) {
        const std::string& called = names.at(scene);
        for (const auto& [kind, name] : KINDS)
            add(fmt::format("trace/{}/embree/{}", name, called),
                [=, kind = kind](benchmark::State& state) { runEmbree(state, scene, kind); });
        for (const auto& backend : cases.backends) {
            const DeviceOptions options{.device = cases.device, .backend = backend};
            for (const auto& [kind, name] : KINDS)
                add(fmt::format("trace/{}/{}/{}", name, backend, called),
                    [=, kind = kind](benchmark::State& state) { runDevice(state, scene, options, kind); });
        }
    }
}

}  // namespace restirpg::bench
