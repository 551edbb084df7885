#include "gpu/kernel.h"

#include <semaphore>
#include <thread>

namespace restirpg {
namespace {

/// As many kernels are compiled at once as there are processors.
std::counting_semaphore<>& processors()
{
    static std::counting_semaphore<> free(std::max(1u, std::thread::hardware_concurrency()));
    return free;
}

struct Turn {
    Turn() { processors().acquire(); }
    ~Turn() { processors().release(); }
};

}  // namespace

Kernel::Kernel(Device& device, const std::filesystem::path& file, const Defines& defines, const Includes& includes,
               Compile when)
    : device_(&device), file_(file), defines_(defines), includes_(includes)
{
    if (when == Compile::atFirstDispatch) {
        compile(std::launch::deferred);
        return;
    }
    // Either policy: where no thread can be had, it is compiled by whoever waits for it.
    compile(std::launch::async | std::launch::deferred);
    device.addKernel(pipeline_);
}

void Kernel::compile(std::launch policy) const
{
    Defines all = device_->kernelDefines();
    for (const auto& [name, value] : defines_)
        all[name] = value;
    generation_ = device_->kernelGeneration();
    pipeline_ = std::async(policy, [&logical = device_->logical(), file = file_, all, includes = includes_] {
                    const Turn turn;
                    return logical.pipelines().get(compileShader(file, all, includes), file.filename().string());
                }).share();
}

const Pipeline& Kernel::pipeline() const
{
    if (generation_ != device_->kernelGeneration())
        compile(std::launch::deferred);
    return *pipeline_.get();
}

void Kernel::dispatch(VkCommandBuffer commands, const void* parameters, uint32_t parameterBytes, uint32_t width,
                      uint32_t height, uint32_t depth) const
{
    const Pipeline& compiled = pipeline();
    const LocalSize& size = compiled.groupSize();
    compiled.bind(commands);
    vkCmdPushConstants(commands, device_->pipelineLayout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, parameterBytes, parameters);
    const auto groups = [](uint32_t invocations, uint32_t size) { return (invocations + size - 1) / size; };
    vkCmdDispatch(commands, groups(width, size.x), groups(height, size.y), groups(depth, size.z));
}

}  // namespace restirpg
