#include "cases.h"

#include "core/error.h"
#include "scene/gltf.h"

#include <map>

namespace restirpg::bench {

namespace {

int failed = 0;

}  // namespace

int failedCases()
{
    return failed;
}

void add(const std::string& name, std::function<void(benchmark::State&)> run)
{
    benchmark::RegisterBenchmark(name.c_str(),
                                 [run = std::move(run)](benchmark::State& state) {
                                     try {
                                         run(state);
                                     } catch (const Error& error) {
                                         state.SkipWithError(error.what());
                                         ++failed;
                                     }
                                 })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
}

std::shared_ptr<const Scene> loadScene(const std::string& file)
{
    static std::map<std::string, std::shared_ptr<const Scene>> loaded;
    auto& scene = loaded[file];
    if (!scene)
        scene = std::make_shared<Scene>(loadGltf(file));
    return scene;
}

}  // namespace restirpg::bench
