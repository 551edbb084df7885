// The Vulkan device: choice, required features, validation, one queue.
#pragma once

#include "gpu/buffer.h"

#include <volk.h>

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace restirpg {

/// Which ray tracing back end the kernels are compiled for.
enum class Backend {
    software,  ///< two-level BVH2 traversed in the kernel; any device
    rayQuery,  ///< GL_EXT_ray_query
};

struct DeviceOptions {
    std::string device;  ///< index or part of the name, as `restirpg devices` lists them; empty: discrete, else integrated, else CPU
    std::string backend;  ///< "software", "rayquery" or empty: ray query where the device has it and is no CPU
    bool validation = false;  ///< validation layer with synchronization validation; RESTIRPG_VALIDATION=1 turns it on too
};

/// A physical device as `restirpg devices` shows it.
struct DeviceDescription {
    std::string name;
    std::string driver;  ///< name and version
    std::string type;  ///< "discrete GPU", "integrated GPU", "virtual GPU", "CPU"
    bool rayQuery = false;
    std::vector<std::string> missing;  ///< required features it lacks; empty: usable
};

std::vector<DeviceDescription> listDevices();

class Device {
public:
    /// Throws Error naming the device, the missing feature and what would provide it.
    explicit Device(const DeviceOptions& options = {});
    ~Device();
    Device(const Device&) = delete;
    Device& operator=(const Device&) = delete;

    const DeviceDescription& description() const { return description_; }
    Backend backend() const { return backend_; }
    bool isCpu() const { return isCpu_; }

    VkDevice handle() const { return device_; }
    VkPhysicalDevice physical() const { return physical_; }
    VkPipelineLayout pipelineLayout() const { return pipelineLayout_; }
    VkDescriptorSetLayout setLayout() const { return setLayout_; }
    double timestampPeriod() const { return timestampPeriod_; }  ///< ns a tick

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

    /// Bytes of device memory allocated now.
    uint64_t allocatedBytes() const { return allocatedBytes_; }

    void setName(uint64_t handle, VkObjectType type, const std::string& name) const;
    void beginLabel(VkCommandBuffer commands, const std::string& name) const;
    void endLabel(VkCommandBuffer commands) const;

    /// Memory for a resource's requirements; counted in allocatedBytes. Freed by freeMemory.
    VkDeviceMemory allocateMemory(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags flags, bool address);
    void freeMemory(VkDeviceMemory memory, uint64_t bytes);

    /// Messages of the validation layer so far.
    const std::vector<std::string>& validationMessages() const { return messages_; }

private:
    friend class Buffer;
    Buffer makeBuffer(uint64_t bytes, VkBufferUsageFlags usage, VkMemoryPropertyFlags flags, const std::string& name);
    void createLayouts();

    DeviceDescription description_;
    Backend backend_ = Backend::software;
    bool isCpu_ = false;
    bool debugUtils_ = false;
    VkInstance instance_ = VK_NULL_HANDLE;
    VkDebugUtilsMessengerEXT messenger_ = VK_NULL_HANDLE;
    VkPhysicalDevice physical_ = VK_NULL_HANDLE;
    VkDevice device_ = VK_NULL_HANDLE;
    VkQueue queue_ = VK_NULL_HANDLE;
    VkCommandPool pool_ = VK_NULL_HANDLE;
    VkFence fence_ = VK_NULL_HANDLE;
    VkDescriptorSetLayout setLayout_ = VK_NULL_HANDLE;
    VkPipelineLayout pipelineLayout_ = VK_NULL_HANDLE;
    double timestampPeriod_ = 1;
    uint64_t allocatedBytes_ = 0;
    VkPhysicalDeviceMemoryProperties memory_{};
    std::vector<std::string> messages_;
    std::map<std::string, std::string> kernelDefines_;
};

/// Bytes of push constants that a kernel's parameters may take: what every Vulkan device has.
constexpr uint32_t MAX_PARAMETER_BYTES = 128;

/// Throws std::runtime_error naming the call when `result` is an error; out of memory is an Error.
void check(VkResult result, const char* call);

}  // namespace restirpg
