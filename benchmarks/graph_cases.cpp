#include "cases.h"

#include "graph/graph.h"
#include "render/bounce_cap.h"
#include "render/renderer.h"

#include <fmt/format.h>

namespace restirpg::bench {
namespace {

struct GraphCase {
    std::string graph, scene, backend, device;
    Size size;
    uint32_t seed;

    /// Of the renderer, which two files of one name do not share.
    std::string key() const
    {
        using std::filesystem::weakly_canonical;
        return weakly_canonical(graph).string() + '\n' + weakly_canonical(scene).string() + '\n' + size.text() + '\n' +
               backend;
    }
};

std::shared_ptr<Renderer> makeRenderer(const GraphCase& c)
{
    const auto scene = loadScene(c.scene);
    auto graph = std::make_unique<Graph>(readGraphFile(c.graph), Plugins());
    capBounces(*graph, *scene, {});
    RendererOptions options;
    options.width = c.size.width;
    options.height = c.size.height;
    options.seed = c.seed;
    options.device = {.device = c.device, .backend = c.backend};
    auto renderer = std::make_shared<Renderer>(scene, std::move(graph), options);
    renderer->render(1);  // kernels are compiled at their first dispatch
    return renderer;
}

void runGraph(benchmark::State& state, const GraphCase& c)
{
    auto& renderer = keep<Renderer>(onDevice(), "graph\n" + c.key(), [&] { return makeRenderer(c); });
    std::map<std::string, double> passes;
    for (auto _ : state) {
        renderer.render(1);
        double milliseconds = 0;
        for (const auto& [pass, time] : renderer.gpuTimes()) {
            passes[pass] += time;
            milliseconds += time;
        }
        state.SetIterationTime(milliseconds / 1e3);
    }
    for (const auto& [pass, time] : passes)
        state.counters["ms:" + pass] = benchmark::Counter(time, benchmark::Counter::kAvgIterations);
    uint64_t bytes = 0;
    for (const auto& [name, size] : renderer.memory())
        bytes += size;
    state.counters["MB"] = double(bytes) / 1e6;
    state.counters["Mpixels/s"] =
        benchmark::Counter(double(c.size.width) * c.size.height / 1e6, benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

void registerGraphs(const Cases& cases)
{
    const auto graphNames = namesOf(cases.graphs), sceneNames = namesOf(cases.scenes);
    for (const auto& graph : cases.graphs)
        for (const auto& scene : cases.scenes)
            for (const auto& size : cases.sizes)
                for (const auto& backend : cases.backends) {
                    const GraphCase c{graph, scene, backend, cases.device, size, cases.seed};
                    add(fmt::format("graph/{}/{}/{}/{}", graphNames.at(graph), sceneNames.at(scene), size.text(),
                                    backend),
                        [c](benchmark::State& state) { runGraph(state, c); });
                }
}

}  // namespace restirpg::bench
