#include "gpu/buffer.h"

#include "core/error.h"
#include "gpu/device.h"

#include <algorithm>
#include <cstring>

namespace restirpg {
namespace {

constexpr VkBufferUsageFlags KERNEL_BUFFER = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT |
                                             VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT |
                                             VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
constexpr VkMemoryPropertyFlags HOST = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT;
constexpr uint64_t STAGING_BYTES = 64u << 20;

}  // namespace

Buffer::~Buffer()
{
    if (!buffer_)
        return;
    if (mapped_)
        vkUnmapMemory(device_->handle(), memory_);
    vkDestroyBuffer(device_->handle(), buffer_, nullptr);
    device_->freeMemory(memory_, memoryBytes_);
}

VkDeviceMemory Device::allocateMemory(const VkMemoryRequirements& requirements, VkMemoryPropertyFlags flags,
                                      bool address)
{
    uint32_t type = UINT32_MAX;
    for (uint32_t i = 0; i < memory_.memoryTypeCount && type == UINT32_MAX; ++i)
        if ((requirements.memoryTypeBits & (1u << i)) && (memory_.memoryTypes[i].propertyFlags & flags) == flags)
            type = i;
    if (type == UINT32_MAX)
        fail("device '{}' has no memory of the kind needed (flags {:#x}); choose another device", description().name,
             flags);
    VkMemoryAllocateFlagsInfo flagsInfo{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_FLAGS_INFO};
    flagsInfo.flags = address ? VK_MEMORY_ALLOCATE_DEVICE_ADDRESS_BIT : 0;
    VkMemoryAllocateInfo info{VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, &flagsInfo};
    info.allocationSize = requirements.size;
    info.memoryTypeIndex = type;
    VkDeviceMemory memory;
    check(vkAllocateMemory(device_, &info, nullptr, &memory), "vkAllocateMemory");
    allocatedBytes_ += requirements.size;
    return memory;
}

void Device::freeMemory(VkDeviceMemory memory, uint64_t bytes)
{
    vkFreeMemory(device_, memory, nullptr);
    allocatedBytes_ -= bytes;
}

Buffer Device::makeBuffer(uint64_t bytes, VkBufferUsageFlags usage, VkMemoryPropertyFlags flags,
                          const std::string& name)
{
    Buffer buffer;
    buffer.device_ = this;
    buffer.bytes_ = bytes;
    VkBufferCreateInfo info{VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO};
    info.size = bytes;
    info.usage = usage;
    check(vkCreateBuffer(device_, &info, nullptr, &buffer.buffer_), "vkCreateBuffer");
    VkMemoryRequirements requirements;
    vkGetBufferMemoryRequirements(device_, buffer.buffer_, &requirements);
    buffer.memory_ = allocateMemory(requirements, flags, usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT);
    buffer.memoryBytes_ = requirements.size;
    check(vkBindBufferMemory(device_, buffer.buffer_, buffer.memory_, 0), "vkBindBufferMemory");
    if (flags & VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT)
        check(vkMapMemory(device_, buffer.memory_, 0, VK_WHOLE_SIZE, 0, &buffer.mapped_), "vkMapMemory");
    if (usage & VK_BUFFER_USAGE_SHADER_DEVICE_ADDRESS_BIT) {
        VkBufferDeviceAddressInfo addressInfo{VK_STRUCTURE_TYPE_BUFFER_DEVICE_ADDRESS_INFO};
        addressInfo.buffer = buffer.buffer_;
        buffer.address_ = vkGetBufferDeviceAddress(device_, &addressInfo);
    }
    setName(uint64_t(buffer.buffer_), VK_OBJECT_TYPE_BUFFER, name);
    return buffer;
}

Buffer Device::createBuffer(uint64_t bytes, const std::string& name)
{
    bytes = std::max<uint64_t>((bytes + 3) / 4 * 4, 16);
    VkBufferUsageFlags usage = KERNEL_BUFFER;
    if (backend() == Backend::rayQuery)
        usage |= VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_BUILD_INPUT_READ_ONLY_BIT_KHR |
                 VK_BUFFER_USAGE_ACCELERATION_STRUCTURE_STORAGE_BIT_KHR;
    const VkMemoryPropertyFlags flags = VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT | (isCpu() ? HOST : 0);
    Buffer buffer = makeBuffer(bytes, usage, flags, name);
    if (buffer.mapped_)
        std::memset(buffer.mapped_, 0, bytes);
    else
        submit([&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer.handle(), 0, VK_WHOLE_SIZE, 0); });
    return buffer;
}

void Device::upload(const Buffer& buffer, const void* data, uint64_t bytes, uint64_t offset)
{
    if (buffer.mapped_) {
        std::memcpy(static_cast<char*>(buffer.mapped_) + offset, data, bytes);
        return;
    }
    if (bytes == 0)
        return;
    Buffer staging = makeBuffer(std::min(bytes, STAGING_BYTES), VK_BUFFER_USAGE_TRANSFER_SRC_BIT, HOST, "staging");
    for (uint64_t done = 0; done < bytes; done += staging.bytes()) {
        const VkBufferCopy copy{0, offset + done, std::min(staging.bytes(), bytes - done)};
        std::memcpy(staging.mapped_, static_cast<const char*>(data) + done, copy.size);
        submit(
            [&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, staging.handle(), buffer.handle(), 1, &copy); });
    }
}

void Device::download(const Buffer& buffer, void* data, uint64_t bytes, uint64_t offset)
{
    if (buffer.mapped_) {
        std::memcpy(data, static_cast<const char*>(buffer.mapped_) + offset, bytes);
        return;
    }
    if (bytes == 0)
        return;
    Buffer staging = makeBuffer(std::min(bytes, STAGING_BYTES), VK_BUFFER_USAGE_TRANSFER_DST_BIT, HOST, "staging");
    for (uint64_t done = 0; done < bytes; done += staging.bytes()) {
        const VkBufferCopy copy{offset + done, 0, std::min(staging.bytes(), bytes - done)};
        submit(
            [&](VkCommandBuffer commands) { vkCmdCopyBuffer(commands, buffer.handle(), staging.handle(), 1, &copy); });
        std::memcpy(static_cast<char*>(data) + done, staging.mapped_, copy.size);
    }
}

}  // namespace restirpg
