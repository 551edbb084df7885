// restirpg_bench: how fast graphs, tracing and BSDF sampling are on a device. `--benchmark_out=FILE.json` writes what
// Google Benchmark's own compare.py compares.
#include "cases.h"

#include "core/error.h"
#include "core/log.h"
#include "graph/graph.h"
#include "render/version.h"

#include <CLI/CLI.hpp>
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <fstream>
#include <string_view>

namespace restirpg::bench {
namespace {

constexpr std::string_view OUT = "--benchmark_out=";

Size parseSize(const std::string& text)
{
    Size size{};
    int length = 0;
    if (std::sscanf(text.c_str(), "%5ux%5u%n", &size.width, &size.height, &length) != 2 ||
        size_t(length) != text.size() || size.width == 0 || size.height == 0)
        fail("--sizes: '{}' is not WIDTHxHEIGHT, as in 320x180", text);
    return size;
}

/// The back ends to measure: what was asked for, or all that the device has. Names the device in the results' context.
std::vector<std::string> chooseBackends(const Cases& cases)
{
    for (const auto& backend : cases.backends)
        Device(DeviceOptions{.device = cases.device, .backend = backend});  // refuses what it does not have
    const Device device(DeviceOptions{.device = cases.device});
    const auto& description = device.description();
    benchmark::AddCustomContext("device", description.name);
    benchmark::AddCustomContext("driver", description.driver);
    benchmark::AddCustomContext("commit", COMMIT);
    if (!cases.backends.empty())
        return cases.backends;
    return description.rayQuery ? std::vector<std::string>{"software", "rayquery"}
                                : std::vector<std::string>{"software"};
}

/// What is left of the command line is Google Benchmark's; what it does not know either is refused.
void handToBenchmark(std::vector<std::string> rest, char* program)
{
    std::vector<char*> arguments{program};
    for (auto& argument : rest)
        arguments.push_back(argument.data());
    int count = int(arguments.size());
    arguments.push_back(nullptr);
    benchmark::Initialize(&count, arguments.data(), [] {  // it would end with 0
        fail("a flag of Google Benchmark has a value that it does not take: formats are console, json and csv, "
             "--benchmark_time_unit is ns, us, ms or s");
    });
    if (count > 1)
        fail("'{}' is no option; --help lists them", arguments[1]);
}

/// Where the results cannot be written, Google Benchmark would end with 1.
void checkOutput(const std::string& file)
{
    std::error_code ignored;
    const bool there = std::filesystem::exists(file, ignored);
    if (!std::ofstream(file, std::ios::app))
        fail("--benchmark_out: {}: cannot be written: {}; name another file", file, std::strerror(errno));
    if (!there)
        std::filesystem::remove(file, ignored);
}

int run(int argc, char** argv)
{
    Cases cases;
    std::vector<std::string> sizes{"160x90", "320x180"};
    const std::string source = RESTIRPG_SOURCE;
    cases.graphs = {source + "/graphs/path_tracer.py"};
    cases.scenes = {source + "/out/scenes/cornell_box.glb", source + "/out/scenes/door_ajar.glb"};
    CLI::App app("Benchmarks. Google Benchmark's own flags may be given too: --benchmark_filter=REGEX, "
                 "--benchmark_out=FILE.json, "
                 "--benchmark_repetitions=N, --benchmark_min_time=SECONDS, --benchmark_list_tests");
    app.allow_extras();
    app.add_option("--graphs", cases.graphs, "graph files (the path tracer)");
    app.add_option("--scenes", cases.scenes,
                   "scenes (the embedded ones in out/scenes: scripts/make_scenes.py writes them)");
    app.add_option("--sizes", sizes, "WIDTHxHEIGHT of the graphs' pictures (160x90 320x180)");
    app.add_option("--backends", cases.backends, "software, rayquery (those that the device has)");
    app.add_option("--device", cases.device,
                   "number or part of the name, as `restirpg devices` shows them (the best one)");
    app.add_option("--seed", cases.seed, "of all random numbers (0)");
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        fail("{}; --help lists the options", error.what());
    }
    handToBenchmark(app.remaining(), argv[0]);
    for (const auto& graph : cases.graphs)
        Graph(readGraphFile(graph), Plugins());  // refuses its mistakes
    for (const auto& scene : cases.scenes)
        if (!std::filesystem::is_regular_file(scene))
            fail("{}: no such scene; scripts/make_scenes.py writes the embedded ones", scene);
    for (const auto& size : sizes)
        cases.sizes.push_back(parseSize(size));
    cases.backends = chooseBackends(cases);
    registerGraphs(cases);
    registerTracing(cases);
    registerBsdfs(cases);
    for (const auto& argument : app.remaining())
        if (argument.starts_with(OUT))
            checkOutput(argument.substr(OUT.size()));
    const size_t run = benchmark::RunSpecifiedBenchmarks();  // which says itself that none matched
    benchmark::Shutdown();
    return run == 0 ? 2 : failedCases() == 0 ? 0 : 1;
}

}  // namespace
}  // namespace restirpg::bench

int main(int argc, char** argv)
{
    try {
        return restirpg::bench::run(argc, argv);
    } catch (const std::exception& error) {
        restirpg::logInfo(fmt::format("restirpg_bench: {}", error.what()));
        return 2;
    }
}
