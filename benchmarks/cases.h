// What the benchmarks measure, and what they share.
#pragma once

#include "gpu/device.h"
#include "scene/scene.h"

#include <benchmark/benchmark.h>

#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace restirpg::bench {

struct Size {
    uint32_t width, height;
    std::string text() const { return std::to_string(width) + "x" + std::to_string(height); }
};

/// What the command line asks for: every graph x scene x size is a case.
struct Cases {
    std::vector<std::string> graphs;
    std::vector<std::string> scenes;
    std::vector<Size> sizes;
    std::vector<std::string> backends;  ///< "software", "rayquery"
    std::string device;
    uint32_t seed = 0;
};

/// graph/GRAPH/SCENE/WxH/BACKEND: frames of a graph after a warm-up frame. Time: the passes' GPU times. Counters: ms of
/// each pass, device memory in MB, millions of pixels a second.
void registerGraphs(const Cases& cases);

/// trace/KIND/BACKEND/SCENE and trace/KIND/embree/SCENE: closest hits of primary and bounce rays, and shadow rays, the
/// same rays for all. Counter: rays a second.
void registerTracing(const Cases& cases);

/// bsdf/MATERIAL: sampling, with evaluation of weight and pdf. Counter: samples a second.
void registerBsdfs(const Cases& cases);

/// Register one case; what it throws is reported as the case's error, and the rest goes on. Throws Error where another
/// case has the name.
void add(const std::string& name, std::function<void(benchmark::State&)> run);
int failedCases();

/// What the cases call each file: its stem, or the whole path where several have that stem.
std::map<std::string, std::string> namesOf(const std::vector<std::string>& files);

/// The scene of a file, loaded once.
std::shared_ptr<const Scene> loadScene(const std::string& file);

/// Google Benchmark calls a case several times until its iterations suffice: what a case needs is made once.
struct Kept {
    std::string key;
    std::shared_ptr<void> object;
};

/// The one object that holds a device: one is alive at a time, so that cases do not share its memory and caches.
Kept& onDevice();

/// What `kept` has under this key; else that is dropped, and a new one made. Keys of different types differ.
template <typename T>
T& keep(Kept& kept, const std::string& key, const std::function<std::shared_ptr<T>()>& make)
{
    if (kept.key != key || !kept.object) {
        kept.object.reset();
        kept.object = make();
        kept.key = key;
    }
    return *static_cast<T*>(kept.object.get());
}

}  // namespace restirpg::bench
