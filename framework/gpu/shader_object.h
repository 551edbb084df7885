// VK_EXT_shader_object: kernels that the driver gives back in a form of its own, to be kept on disk.
#pragma once

#include <volk.h>

#include <cstddef>
#include <span>
#include <vector>

#ifndef VK_EXT_shader_object  // Vulkan headers before 1.3.246
VK_DEFINE_NON_DISPATCHABLE_HANDLE(VkShaderEXT)
#define VK_EXT_SHADER_OBJECT_EXTENSION_NAME "VK_EXT_shader_object"

constexpr auto VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_OBJECT_FEATURES_EXT = VkStructureType(1000482000);
constexpr auto VK_STRUCTURE_TYPE_SHADER_CREATE_INFO_EXT = VkStructureType(1000482002);

enum VkShaderCodeTypeEXT { VK_SHADER_CODE_TYPE_BINARY_EXT = 0, VK_SHADER_CODE_TYPE_SPIRV_EXT = 1 };

struct VkPhysicalDeviceShaderObjectFeaturesEXT {
    VkStructureType sType;
    void* pNext;
    VkBool32 shaderObject;
};

struct VkShaderCreateInfoEXT {
    VkStructureType sType;
    const void* pNext;
    VkFlags flags;
    VkShaderStageFlagBits stage;
    VkShaderStageFlags nextStage;
    VkShaderCodeTypeEXT codeType;
    size_t codeSize;
    const void* pCode;
    const char* pName;
    uint32_t setLayoutCount;
    const VkDescriptorSetLayout* pSetLayouts;
    uint32_t pushConstantRangeCount;
    const VkPushConstantRange* pPushConstantRanges;
    const VkSpecializationInfo* pSpecializationInfo;
};

using PFN_vkCreateShadersEXT = VkResult(VKAPI_PTR*)(VkDevice, uint32_t, const VkShaderCreateInfoEXT*,
                                                    const VkAllocationCallbacks*, VkShaderEXT*);
using PFN_vkDestroyShaderEXT = void(VKAPI_PTR*)(VkDevice, VkShaderEXT, const VkAllocationCallbacks*);
using PFN_vkGetShaderBinaryDataEXT = VkResult(VKAPI_PTR*)(VkDevice, VkShaderEXT, size_t*, void*);
using PFN_vkCmdBindShadersEXT = void(VKAPI_PTR*)(VkCommandBuffer, uint32_t, const VkShaderStageFlagBits*,
                                                 const VkShaderEXT*);
#endif

namespace restirpg {

/// The extension on one device, for compute shaders without descriptor sets. Functions may be called by several
/// threads at once.
class ShaderObjects {
public:
    /// The extension on no device.
    ShaderObjects() = default;
    /// `device` must have been made with the extension.
    explicit ShaderObjects(VkDevice device);

    /// Is this of a device?
    explicit operator bool() const { return device_ != VK_NULL_HANDLE; }

    /// From SPIR-V, or from what binary() gave. VK_NULL_HANDLE where the driver does not take that binary: it was of
    /// another version.
    VkShaderEXT make(VkShaderCodeTypeEXT type, std::span<const std::byte> code) const;
    /// The driver's own form of it.
    std::vector<std::byte> binary(VkShaderEXT shader) const;
    void destroy(VkShaderEXT shader) const { destroy_(device_, shader, nullptr); }
    void bind(VkCommandBuffer commands, VkShaderEXT shader) const;

private:
    VkDevice device_ = VK_NULL_HANDLE;
    PFN_vkCreateShadersEXT create_ = nullptr;
    PFN_vkDestroyShaderEXT destroy_ = nullptr;
    PFN_vkGetShaderBinaryDataEXT getBinaryData_ = nullptr;
    PFN_vkCmdBindShadersEXT cmdBind_ = nullptr;
};

}  // namespace restirpg
