#include "render/frame.h"

#include "core/memory.h"
#include "gpu/device.h"

#include <fmt/format.h>

namespace restirpg {

void checkFits(const Device& device, const std::string& place, uint32_t width, uint32_t height, uint64_t bytes)
{
    if (device.isCpu())
        checkMemory(place, fmt::format("a frame of {}x{} pixels", width, height), bytes,
                    "give a smaller --size or a --window");
}

void Frame::barrier()
{
    VkMemoryBarrier barrier{VK_STRUCTURE_TYPE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_SHADER_READ_BIT | VK_ACCESS_SHADER_WRITE_BIT | VK_ACCESS_TRANSFER_READ_BIT |
                            VK_ACCESS_TRANSFER_WRITE_BIT;
    constexpr VkPipelineStageFlags STAGES = VK_PIPELINE_STAGE_COMPUTE_SHADER_BIT | VK_PIPELINE_STAGE_TRANSFER_BIT;
    vkCmdPipelineBarrier(commands_, STAGES, STAGES, 0, 1, &barrier, 0, nullptr, 0, nullptr);
}

uint64_t Frame::scratch(Buffer& buffer, uint64_t bytes, const char* name)
{
    if (buffer.bytes() < bytes) {
        checkFits(device_, name, width_, height_, bytes);
        buffer = device_.createBuffer(bytes, name);
    }
    scratch_[&buffer] = buffer.bytes();
    return buffer.address();
}

uint64_t Frame::takeScratchBytes()
{
    uint64_t sum = 0;
    for (const auto& [buffer, bytes] : std::exchange(scratch_, {}))
        sum += bytes;
    return sum;
}

void Frame::copy(const Buffer& from, const Buffer& to)
{
    barrier();
    const VkBufferCopy region{0, 0, from.bytes()};
    vkCmdCopyBuffer(commands_, from.handle(), to.handle(), 1, &region);
}

void Frame::fill(const Buffer& buffer, uint32_t word, uint64_t bytes)
{
    barrier();
    vkCmdFillBuffer(commands_, buffer.handle(), 0, bytes, word);
}

}  // namespace restirpg
