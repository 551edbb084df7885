// Textures and the one descriptor set that every kernel sees.
#pragma once

#include "gpu/device.h"

#include <cstdint>
#include <span>
#include <string>
#include <vector>

namespace restirpg {

/// What a sampled image is made from. Exactly one of the pixel spans is filled; RGBA, rows from the top.
struct TextureSource {
    std::string name;
    uint32_t width = 1;
    uint32_t height = 1;
    bool srgb = false;
    std::span<const uint8_t> bytes;
    std::span<const float> floats;
    VkSamplerAddressMode wrapU = VK_SAMPLER_ADDRESS_MODE_REPEAT;
    VkSamplerAddressMode wrapV = VK_SAMPLER_ADDRESS_MODE_REPEAT;
    VkFilter filter = VK_FILTER_LINEAR;
};

/// The texture array (binding 1) and, for ray query, the acceleration structure (binding 0), in one descriptor set.
class BindingSet {
public:
    /// Throws Error when there are more textures than the device binds.
    BindingSet(Device& device, std::span<const TextureSource> textures);
    ~BindingSet();
    BindingSet(const BindingSet&) = delete;
    BindingSet& operator=(const BindingSet&) = delete;

    void setAccelerationStructure(VkAccelerationStructureKHR structure);
    void bind(VkCommandBuffer commands) const;

private:
    struct Texture {
        VkImage image = VK_NULL_HANDLE;
        VkDeviceMemory memory = VK_NULL_HANDLE;
        uint64_t memoryBytes = 0;
        VkImageView view = VK_NULL_HANDLE;
        VkSampler sampler = VK_NULL_HANDLE;
    };
    Texture createTexture(const TextureSource& source);
    void writeTextures();

    Device& device_;
    std::vector<Texture> textures_;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace restirpg
