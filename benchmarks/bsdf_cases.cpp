#include "cases.h"

#include "Shared.h"
#include "gpu/binding_set.h"
#include "gpu/kernel.h"
#include "scene/fresnel.h"

#include <chrono>

namespace restirpg::bench {
namespace {

constexpr uint32_t THREADS = 1 << 16, SAMPLES = 16;

struct NamedMaterial {
    const char* name;
    float metallic, roughness, transmission;
    bool solid;
};
constexpr NamedMaterial MATERIALS[] = {{"diffuse_and_coat", 0, 0.5f, 0, false},
                                       {"rough_metal", 1, 0.3f, 0, false},
                                       {"mirror", 1, 0, 0, false},
                                       {"rough_glass", 0, 0.3f, 1, true},
                                       {"smooth_glass", 0, 0, 1, true}};

struct Sampler {
    Device device;
    BindingSet noScene{device};
    Kernel kernel;
    Buffer sums;

    explicit Sampler(const DeviceOptions& options)
        : device(options), kernel(device, std::string(RESTIRPG_SOURCE) + "/benchmarks/bsdf_sampling.comp"),
          sums(device.createBuffer(THREADS * sizeof(glm::vec3), "sums"))
    {
    }

    void run(const BsdfSamplingParameters& parameters)
    {
        device.submit([&](VkCommandBuffer commands) {
            noScene.bind(commands);
            kernel.dispatch(commands, &parameters, sizeof parameters, THREADS);
        });
    }
};

void runBsdf(benchmark::State& state, const DeviceOptions& options, const NamedMaterial& material)
{
    using Clock = std::chrono::steady_clock;
    constexpr float IOR = 1.5f;
    auto& sampler = keep<Sampler>(onDevice(), "bsdf", [&] { return std::make_shared<Sampler>(options); });
    const BsdfSamplingParameters parameters{sampler.sums.address(),
                                            THREADS,
                                            SAMPLES,
                                            material.metallic,
                                            material.roughness,
                                            material.transmission,
                                            IOR,
                                            fresnelCoatAverage(IOR),
                                            material.solid};
    sampler.run(parameters);  // compiles the kernel
    for (auto _ : state) {
        const auto start = Clock::now();
        sampler.run(parameters);
        state.SetIterationTime(std::chrono::duration<double>(Clock::now() - start).count());
    }
    state.counters["samples/s"] =
        benchmark::Counter(double(THREADS) * SAMPLES, benchmark::Counter::kIsIterationInvariantRate);
}

}  // namespace

void registerBsdfs(const Cases& cases)
{
    const DeviceOptions options{.device = cases.device};
    for (const auto& material : MATERIALS)
        add(std::string("bsdf/") + material.name, [=](benchmark::State& state) { runBsdf(state, options, material); });
}

}  // namespace restirpg::bench
