#include "cases.h"

#include "core/error.h"
#include "scene/gltf.h"

#include <algorithm>
#include <exception>
#include <filesystem>
#include <set>

namespace restirpg::bench {

namespace {

int failed = 0;

}  // namespace

int failedCases()
{
    return failed;
}

Kept& onDevice()
{
    static Kept kept;
    return kept;
}

void add(const std::string& name, std::function<void(benchmark::State&)> run)
{
    static std::set<std::string> names;
    if (!names.insert(name).second)
        fail("two cases would be called {}; give each graph, scene, size and back end once", name);
    benchmark::RegisterBenchmark(name.c_str(),
                                 [run = std::move(run)](benchmark::State& state) {
                                     try {
                                         run(state);
                                     } catch (const std::exception& error) {
                                         state.SkipWithError(error.what());
                                         ++failed;
                                     }
                                 })
        ->UseManualTime()
        ->Unit(benchmark::kMillisecond);
}

std::map<std::string, std::string> namesOf(const std::vector<std::string>& files)
{
    const auto stem = [](const std::string& file) { return std::filesystem::path(file).stem().string(); };
    std::map<std::string, std::string> names;
    for (const auto& file : files) {
        const bool alone = std::all_of(files.begin(), files.end(), [&](const std::string& other) {
            return other == file || stem(other) != stem(file);
        });
        names[file] = alone ? stem(file) : file;
    }
    return names;
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
