#include "gpu/kernel.h"

#include "core/error.h"

namespace restirpg {

Kernel::Kernel(Device& device, const std::filesystem::path& file, const Defines& defines, const Includes& includes)
    : device_(&device)
{
    Defines all = device.kernelDefines();
    for (const auto& [name, value] : defines)
        all[name] = value;
    const auto spirv = compileShader(file, all, includes);
    groupSize_ = localSize(spirv);

    VkShaderModuleCreateInfo moduleInfo{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    moduleInfo.codeSize = spirv.size() * 4;
    moduleInfo.pCode = spirv.data();
    VkShaderModule module;
    check(vkCreateShaderModule(device.handle(), &moduleInfo, nullptr, &module), "vkCreateShaderModule");
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.layout = device.pipelineLayout();
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    const VkResult result = vkCreateComputePipelines(device.handle(), VK_NULL_HANDLE, 1, &info, nullptr, &pipeline_);
    vkDestroyShaderModule(device.handle(), module, nullptr);
    check(result, "vkCreateComputePipelines");
    device.setName(uint64_t(pipeline_), VK_OBJECT_TYPE_PIPELINE, file.filename().string());
}

Kernel::~Kernel()
{
    if (pipeline_)
        vkDestroyPipeline(device_->handle(), pipeline_, nullptr);
}

void Kernel::swap(Kernel& other) noexcept
{
    std::swap(device_, other.device_);
    std::swap(pipeline_, other.pipeline_);
    std::swap(groupSize_, other.groupSize_);
}

void Kernel::dispatch(VkCommandBuffer commands, const void* parameters, uint32_t parameterBytes, uint32_t width,
                      uint32_t height, uint32_t depth) const
{
    vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipeline_);
    vkCmdPushConstants(commands, device_->pipelineLayout(), VK_SHADER_STAGE_COMPUTE_BIT, 0, parameterBytes, parameters);
    const auto groups = [](uint32_t invocations, uint32_t size) { return (invocations + size - 1) / size; };
    vkCmdDispatch(commands, groups(width, groupSize_.x), groups(height, groupSize_.y), groups(depth, groupSize_.z));
}

}  // namespace restirpg
