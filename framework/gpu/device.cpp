#include "gpu/device.h"

#include <algorithm>

namespace restirpg {
namespace {

/// Everything written before is visible to everything after, the host included.
void fullBarrier(VkCommandBuffer commands)
{
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT,
                         VK_PIPELINE_STAGE_ALL_COMMANDS_BIT | VK_PIPELINE_STAGE_HOST_BIT, 0, 1, &barrier, 0, nullptr, 0,
                         nullptr);
}

}  // namespace

Device::Device(std::shared_ptr<LogicalDevice> logical)
    : logical_(std::move(logical)), device_(logical_->handle()), firstMessage_(logical_->messages().size())
{
    setKernelDefine("RESTIRPG_RAY_QUERY", backend() == Backend::rayQuery ? "1" : "0");
    setKernelDefine("RESTIRPG_ALPHA_MASK", "0");
    setKernelDefine("RESTIRPG_ONE_LEVEL", "0");
    vkGetPhysicalDeviceMemoryProperties(physical(), &memory_);

    VkCommandPoolCreateInfo pool{VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
    pool.queueFamilyIndex = logical_->queueFamily();
    pool.flags = VK_COMMAND_POOL_CREATE_TRANSIENT_BIT;
    check(vkCreateCommandPool(device_, &pool, nullptr, &pool_), "vkCreateCommandPool");
    VkFenceCreateInfo fence{VK_STRUCTURE_TYPE_FENCE_CREATE_INFO};
    check(vkCreateFence(device_, &fence, nullptr, &fence_), "vkCreateFence");
}

Device::~Device()
{
    vkDestroyFence(device_, fence_, nullptr);
    vkDestroyCommandPool(device_, pool_, nullptr);
}

void Device::submit(const std::function<void(VkCommandBuffer)>& record)
{
    VkCommandBufferAllocateInfo allocate{VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO};
    allocate.commandPool = pool_;
    allocate.level = VK_COMMAND_BUFFER_LEVEL_PRIMARY;
    allocate.commandBufferCount = 1;
    VkCommandBuffer commands;
    check(vkAllocateCommandBuffers(device_, &allocate, &commands), "vkAllocateCommandBuffers");
    struct Guard {
        VkDevice device;
        VkCommandPool pool;
        VkCommandBuffer commands;
        ~Guard() { vkFreeCommandBuffers(device, pool, 1, &commands); }
    } guard{device_, pool_, commands};

    VkCommandBufferBeginInfo begin{VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
    begin.flags = VK_COMMAND_BUFFER_USAGE_ONE_TIME_SUBMIT_BIT;
    check(vkBeginCommandBuffer(commands, &begin), "vkBeginCommandBuffer");
    fullBarrier(commands);
    record(commands);
    fullBarrier(commands);
    check(vkEndCommandBuffer(commands), "vkEndCommandBuffer");

    VkSubmitInfo submit{VK_STRUCTURE_TYPE_SUBMIT_INFO};
    submit.commandBufferCount = 1;
    submit.pCommandBuffers = &commands;
    logical_->submit(submit, fence_);
    logical_->checkWork(vkWaitForFences(device_, 1, &fence_, VK_TRUE, UINT64_MAX), "vkWaitForFences");
    check(vkResetFences(device_, 1, &fence_), "vkResetFences");
    if (const auto messages = validationMessages(); !messages.empty())
        throw std::runtime_error("Vulkan validation: " + messages.front());
}

void Device::finishKernels(const CompileProgress& progress)
{
    const auto kernels = std::exchange(kernels_, {});
    for (size_t i = 0; i < kernels.size(); ++i) {
        if (progress)
            progress(uint32_t(i), uint32_t(kernels.size()));
        kernels[i].get();
    }
}

void Device::beginLabel(VkCommandBuffer commands, const std::string& name) const
{
    if (!vkCmdBeginDebugUtilsLabelEXT)  // the loader lacks the extension
        return;
    VkDebugUtilsLabelEXT label{VK_STRUCTURE_TYPE_DEBUG_UTILS_LABEL_EXT};
    label.pLabelName = name.c_str();
    vkCmdBeginDebugUtilsLabelEXT(commands, &label);
}

void Device::endLabel(VkCommandBuffer commands) const
{
    if (vkCmdEndDebugUtilsLabelEXT)
        vkCmdEndDebugUtilsLabelEXT(commands);
}

}  // namespace restirpg
