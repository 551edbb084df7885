#include "gpu/pipeline.h"

#include "core/cache_file.h"
#include "core/hash.h"
#include "core/paths.h"
#include "gpu/device.h"

#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <span>

namespace restirpg {
namespace {

/// Pipelines kept that no kernel uses now. One of lavapipe takes up to a few MB.
constexpr size_t MAX_KEPT = 96;

/// What may be kept of a kernel: its SPIR-V on one driver, in the form that the device's kernels have.
Hash hashOf(const LogicalDevice& device, const Spirv& spirv)
{
    Hash hash;
    hash.add(spirv.data(), spirv.size() * sizeof(uint32_t));
    hash.add(device.description().driver);
    hash.add(device.shaderObjects() ? "shader object" : "pipeline");
    return hash;
}

/// A file of the per-user cache; empty where there is none.
std::filesystem::path keptFile(const char* kind, const Hash& hash)
{
    const auto folder = cacheFolder();
    return folder.empty() ? folder : folder / kind / fmt::format("{:016x}", hash.value());
}

/// Where to note that the driver has compiled this SPIR-V before and kept the result; empty: nowhere. The driver's own
/// cache is not ours to look into: a note that is wrong, since that cache was emptied, costs time at the first frame
/// and nothing else.
std::filesystem::path noteOf(const LogicalDevice& device, const Spirv& spirv)
{
    const char* driverCache = std::getenv("MESA_SHADER_CACHE_DIR");
    Hash hash = hashOf(device, spirv);
    hash.add(driverCache ? driverCache : "");
    return keptFile("compiled", hash);
}

/// lavapipe compiles a kernel to machine code at its first dispatch, for seconds, in the one thread of the queue, and
/// keeps the code on disk. A dispatch of no groups on a device of our own makes it do so in this thread's time, beside
/// other kernels.
void compileAhead(const LogicalDevice& original, const Spirv& spirv)
{
    const auto note = noteOf(original, spirv);
    if (note.empty() || readCacheFile(note))
        return;
    Device device(std::make_shared<LogicalDevice>(original));
    const Pipeline pipeline(device.logical(), spirv, "");
    device.submit([&](VkCommandBuffer commands) {
        const std::array<std::byte, MAX_PARAMETER_BYTES> parameters{};  // read by nobody, but have to be there
        vkCmdPushConstants(commands, device.pipelineLayout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, parameters.size(),
                           parameters.data());
        pipeline.bind(commands);
        vkCmdDispatch(commands, 0, 0, 0);
    });
    writeCacheFile(note, {});
}

}  // namespace

Pipeline::Pipeline(const LogicalDevice& device, const Spirv& spirv, const std::string& name)
    : device_(device), groupSize_(localSize(spirv))
{
    if (device.shaderObjects())
        makeShader(spirv);
    else
        makePipeline(spirv, name);
}

Pipeline::~Pipeline()
{
    if (shader_)
        device_.shaderObjects().destroy(shader_);
    vkDestroyPipeline(device_.handle(), pipeline_, nullptr);
}

/// From the driver's own form of the kernel, which is kept on disk. lavapipe spends 70% of a start on turning SPIR-V
/// into that form, and no pipeline cache of its own spares it that (benchmarks/results/speed).
void Pipeline::makeShader(const Spirv& spirv)
{
    const ShaderObjects& objects = device_.shaderObjects();
    const auto file = keptFile("binary", hashOf(device_, spirv));
    if (const auto kept = file.empty() ? std::nullopt : readCacheFile(file))
        shader_ = objects.make(VK_SHADER_CODE_TYPE_BINARY_EXT, *kept);
    if (shader_)
        return;
    const VkShaderEXT translated = objects.make(VK_SHADER_CODE_TYPE_SPIRV_EXT, std::as_bytes(std::span(spirv)));
    if (!file.empty()) {
        // Made again from its binary, as later starts do: lavapipe keeps machine code under a name that differs between
        // the two.
        const auto binary = objects.binary(translated);
        writeCacheFile(file, binary);
        shader_ = objects.make(VK_SHADER_CODE_TYPE_BINARY_EXT, binary);
    }
    if (shader_)
        objects.destroy(translated);
    else
        shader_ = translated;
}

void Pipeline::makePipeline(const Spirv& spirv, const std::string& name)
{
    VkShaderModuleCreateInfo moduleInfo{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    moduleInfo.codeSize = spirv.size() * sizeof(uint32_t);
    moduleInfo.pCode = spirv.data();
    VkShaderModule module;
    check(vkCreateShaderModule(device_.handle(), &moduleInfo, nullptr, &module), "vkCreateShaderModule");
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.layout = device_.pipelineLayout();
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    const VkResult result = vkCreateComputePipelines(device_.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
    vkDestroyShaderModule(device_.handle(), module, nullptr);
    check(result, "vkCreateComputePipelines");
    device_.setName(uint64_t(pipeline_), VK_OBJECT_TYPE_PIPELINE, name);
}

void Pipeline::bind(VkCommandBuffer commands) const
{
    if (shader_)
        device_.shaderObjects().bind(commands, shader_);
    else
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
}

std::shared_ptr<const Pipeline> PipelineCache::get(const Spirv& spirv, const std::string& name)
{
    std::promise<Made> promise;
    {
        std::unique_lock lock(mutex_);
        if (const auto found = pipelines_.find(spirv); found != pipelines_.end()) {
            const auto made = found->second;
            lock.unlock();
            return made.get();  // waits for the thread that makes it
        }
        dropUnused();
        pipelines_.emplace(spirv, promise.get_future().share());
    }
    try {
        // Kernels of the other back end want an acceleration structure bound.
        if (device_.isCpu() && device_.backend() == Backend::software)
            compileAhead(device_, spirv);
        auto made = std::make_shared<const Pipeline>(device_, spirv, name);
        promise.set_value(made);
        return made;
    } catch (...) {
        std::lock_guard lock(mutex_);
        pipelines_.erase(spirv);
        promise.set_exception(std::current_exception());
        throw;
    }
}

void PipelineCache::dropUnused()
{
    if (pipelines_.size() < MAX_KEPT)
        return;
    std::erase_if(pipelines_, [](const auto& entry) {
        const auto& future = entry.second;
        return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready && future.get().use_count() == 1;
    });
}

}  // namespace restirpg
