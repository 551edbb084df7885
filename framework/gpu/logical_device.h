// What all renderers of a process on one device share: instance, logical device, queue, layouts and pipelines.
#pragma once

#include "gpu/device_choice.h"
#include "gpu/pipeline.h"

#include <volk.h>

#include <atomic>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

namespace restirpg {

std::vector<DeviceDescription> listDevices();

/// Ticks from one time stamp to a later one, which have so many bits (timestampValidBits) and start over at 0.
constexpr uint64_t ticksBetween(uint64_t begin, uint64_t end, uint32_t bits)
{
    return (end - begin) & (UINT64_MAX >> (64 - bits));
}

/// Every function may be called by several threads at once.
class LogicalDevice {
public:
    /// The one of this process for these options. Unless it is lost, it lives until the process ends, for the sake of
    /// its pipelines. Throws Error naming the device, the missing feature and what would provide it.
    static std::shared_ptr<LogicalDevice> get(const DeviceOptions& options);

    explicit LogicalDevice(const DeviceOptions& options);
    /// Another of the same physical device, without validation; `original` must outlive it. Several threads may make
    /// and destroy such devices while others use theirs.
    explicit LogicalDevice(const LogicalDevice& original);
    ~LogicalDevice();
    LogicalDevice& operator=(const LogicalDevice&) = delete;

    const DeviceDescription& description() const { return description_; }
    Backend backend() const { return backend_; }
    bool isCpu() const { return description_.isCpu(); }

    VkDevice handle() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    uint32_t queueFamily() const { return queueFamily_; }
    VkPipelineLayout pipelineLayout() const { return pipelineLayout_; }
    VkDescriptorSetLayout setLayout() const { return setLayout_; }
    /// Milliseconds between two time stamps of the queue.
    double milliseconds(uint64_t begin, uint64_t end) const
    {
        return double(ticksBetween(begin, end, timestampBits_)) * timestampPeriod_ * 1e-6;
    }

    const ShaderObjects& shaderObjects() const { return shaderObjects_; }  ///< what kernels are, if any

    PipelineCache& pipelines() { return pipelines_; }
    void setName(uint64_t handle, VkObjectType type, const std::string& name) const;
    void submit(const VkSubmitInfo& work, VkFence fence);
    /// As check() below, of a call that gives the device work or waits for it. Once it is lost, get() makes another.
    void checkWork(VkResult result, const char* call);

    /// Messages of the validation layer so far, but for the first ones.
    std::vector<std::string> messages(size_t first = 0) const;
    void addMessage(const std::string& message);

private:
    void create(const DeviceOptions& options);
    void createDevice(bool shaderObjects);
    void createLayouts();
    void destroy();

    DeviceDescription description_;
    Backend backend_ = Backend::software;
    bool validated_ = false;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    // Only of a validated device: the same physical device without the layer. The layer keeps its devices in a table
    // without a lock (KhronosGroup/Vulkan-ValidationLayers#4391), so threads must not make devices under it.
    VkInstance plainInstance_ = VK_NULL_HANDLE;
    VkPhysicalDevice plainPhysical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    uint32_t queueFamily_ = 0;
    VkQueue queue_ = VK_NULL_HANDLE;
    std::mutex queueMutex_;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkPipelineLayout pipelineLayout_ = VK_NULL_HANDLE;
    double timestampPeriod_ = 1;  ///< ns a tick
    uint32_t timestampBits_ = 64;
    std::atomic<bool> lost_ = false;
    ShaderObjects shaderObjects_;
    PipelineCache pipelines_{*this};
    mutable std::mutex messageMutex_;
    std::vector<std::string> messages_;
};

/// Bytes of push constants that a kernel's parameters may take: what every Vulkan device has.
constexpr uint32_t MAX_PARAMETER_BYTES = 128;

/// Throws Error naming the call when `result` is one.
void check(VkResult result, const char* call);

}  // namespace restirpg
