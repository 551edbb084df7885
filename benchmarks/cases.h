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

/// Register one case; an Error of its own is reported as the case's error, and the rest goes on. Throws Error where
/// another case has the name.
void add(const std::string& name, std::function<void(benchmark::State&)> run);
int failedCases();

/// What the cases call each file: its stem, or the whole path where several have that stem.
std::map<std::string, std::string> namesOf(const std::vector<std::string>& files);

/// The scene of a file, loaded once.
std::shared_ptr<const Scene> loadScene(const std::string& file);

/// Google Benchmark calls a case several times until its iterations suffice: make what a case needs once, keep it until
/// another case (another key) needs something. One is alive at a time, so that cases do not share memory or caches.
template <typename T>
T& keep(const std::string& key, const std::function<std::shared_ptr<T>()>& make)
{
    static std::string kept;
    static std::shared_ptr<T> object;
    if (kept != key || !object) {
        object.reset();
        object = make();
        kept = key;
    }
    return *object;
}

}  // namespace restirpg::bench
