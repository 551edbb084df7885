// A buffer in device memory, used by its address.
#pragma once

#include <volk.h>

#include <cstdint>
#include <string>
#include <utility>

namespace restirpg {

class Device;

/// Move-only owner. Device::createBuffer makes one.
class Buffer {
public:
    Buffer() = default;
    Buffer(Buffer&& other) noexcept { swap(other); }
    Buffer& operator=(Buffer&& other) noexcept
    {
        swap(other);
        return *this;
    }
    ~Buffer();

    uint64_t address() const { return address_; }
    uint64_t bytes() const { return bytes_; }
    VkBuffer handle() const { return buffer_; }
    explicit operator bool() const { return buffer_ != VK_NULL_HANDLE; }

private:
    friend class Device;
    void swap(Buffer& other) noexcept
    {
        std::swap(device_, other.device_);
        std::swap(buffer_, other.buffer_);
        std::swap(memory_, other.memory_);
        std::swap(address_, other.address_);
        std::swap(bytes_, other.bytes_);
        std::swap(memoryBytes_, other.memoryBytes_);
        std::swap(mapped_, other.mapped_);
    }

    Device* device_ = nullptr;
    VkBuffer buffer_ = VK_NULL_HANDLE;
    VkDeviceMemory memory_ = VK_NULL_HANDLE;
    uint64_t address_ = 0;
    uint64_t bytes_ = 0;
    uint64_t memoryBytes_ = 0;
    void* mapped_ = nullptr;  ///< null unless the memory is visible to the host
};

}  // namespace restirpg
