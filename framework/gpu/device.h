// A device as one renderer sees it: buffers, command submission, definitions for its kernels.
#pragma once

#include "gpu/buffer.h"
#include "gpu/logical_device.h"

#include <cstdint>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace restirpg {

/// Called while kernels are compiled.
using CompileProgress = std::function<void(uint32_t done, uint32_t total)>;

class Device {
public:
    /// Throws Error naming the device, the missing feature and what would provide it.
    explicit Device(const DeviceOptions& options = {}) : Device(LogicalDevice::get(options)) {}
    explicit Device(std::shared_ptr<LogicalDevice> logical);
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    LogicalDevice& logical() const { return *logical_; }
    const DeviceDescription& description() const { return logical_->description(); }
    Backend backend() const { return logical_->backend(); }
    bool isCpu() const { return logical_->isCpu(); }

    VkDevice handle() const { return device_; }
    VkPhysicalDevice physical() const { return logical_->physical(); }
    VkPipelineLayout pipelineLayout() const { return logical_->pipelineLayout(); }
    VkDescriptorSetLayout setLayout() const { return logical_->setLayout(); }

    /// A zeroed buffer, readable and writable by kernels through its address.
    Buffer createBuffer(uint64_t bytes, const std::string& name);
    /// A buffer with contents.
    template <typename Range>
    Buffer createBuffer(const Range& contents, const std::string& name)
    {
        Buffer buffer = createBuffer(std::max<uint64_t>(contents.size() * sizeof(*contents.data()), 16), name);
        upload(buffer, contents.data(), contents.size() * sizeof(*contents.data()));
        return buffer;
    }
    void upload(const Buffer& buffer, const void* data, uint64_t bytes, uint64_t offset = 0);
    void download(const Buffer& buffer, void* data, uint64_t bytes, uint64_t offset = 0);
    template <typename T>
    std::vector<T> download(const Buffer& buffer, uint64_t count)
    {
        std::vector<T> values(count);
        download(buffer, values.data(), count * sizeof(T));
        return values;
    }

    /// Record commands, submit them and wait. Throws when a validation message came up meanwhile.
    void submit(const std::function<void(VkCommandBuffer)>& record);

    /// A preprocessor definition that every kernel built from now on gets (the back end, what the scene needs).
    void setKernelDefine(const std::string& name, const std::string& value) { kernelDefines_[name] = value; }
    const std::map<std::string, std::string>& kernelDefines() const { return kernelDefines_; }
    /// The same when kernels may be there already: at another value each is compiled again at its next dispatch.
    void changeKernelDefine(const std::string& name, const std::string& value)
    {
        if (const auto found = kernelDefines_.find(name); found != kernelDefines_.end() && found->second == value)
            return;
        setKernelDefine(name, value);
        ++kernelGeneration_;
    }
    uint32_t kernelGeneration() const { return kernelGeneration_; }

    /// Kernels are compiled side by side, in threads of their own: wait for all that were made for this device, throw
    /// the Error of the first that failed.
    void finishKernels(const CompileProgress& progress = {});
    /// Forget those that nobody will wait for.
    void dropKernels() { kernels_.clear(); }
    void addKernel(std::shared_future<std::shared_ptr<const Pipeline>> kernel)
    {
        kernels_.push_back(std::move(kernel));
    }

    /// Bytes of device memory allocated now.
    uint64_t allocatedBytes() const { return allocatedBytes_; }

    void setName(uint64_t handle, VkObjectType type, const std::string& name) const
    {
        logical_->setName(handle, type, name);
    }
    void beginLabel(VkCommandBuffer commands, const std::string& name) const;
    void endLabel(VkCommandBuffer commands) const;

    /// Memory for a resource's requirements; counted in allocatedBytes. Freed by freeMemory.
    VkDeviceMemory allocateMemory(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags flags, bool address);
    void freeMemory(VkDeviceMemory memory, uint64_t bytes);

    /// Messages of the validation layer since this device was made.
    std::vector<std::string> validationMessages() const { return logical_->messages(firstMessage_); }

private:
    friend class Buffer;
    Buffer makeBuffer(uint64_t bytes, VkBufferUsageFlags usage, VkMemoryPropertyFlags flags, const std::string& name);

    std::shared_ptr<LogicalDevice> logical_;
    VkDevice device_ = VK_NULL_HANDLE;
    size_t firstMessage_ = 0;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    uint64_t allocatedBytes_ = 0;
    VkPhysicalDeviceMemoryProperties memory_{};
    std::vector<std::shared_future<std::shared_ptr<const Pipeline>>> kernels_;  ///< since the last finishKernels
    std::map<std::string, std::string> kernelDefines_;
    uint32_t kernelGeneration_ = 0;
};

}  // namespace restirpg
