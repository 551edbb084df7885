#include "gpu/shader_object.h"

#include "gpu/logical_device.h"

namespace restirpg {

ShaderObjects::ShaderObjects(VkDevice device)
    : device_(device), create_(PFN_vkCreateShadersEXT(vkGetDeviceProcAddr(device, "vkCreateShadersEXT"))),
      destroy_(PFN_vkDestroyShaderEXT(vkGetDeviceProcAddr(device, "vkDestroyShaderEXT"))),
      getBinaryData_(PFN_vkGetShaderBinaryDataEXT(vkGetDeviceProcAddr(device, "vkGetShaderBinaryDataEXT"))),
      cmdBind_(PFN_vkCmdBindShadersEXT(vkGetDeviceProcAddr(device, "vkCmdBindShadersEXT")))
{
}

VkShaderEXT ShaderObjects::make(VkShaderCodeTypeEXT type, std::span<const std::byte> code) const
{
    const VkPushConstantRange parameters{VK_SHADER_STAGE_COMPUTE_BIT, 0, MAX_PARAMETER_BYTES};
    VkShaderCreateInfoEXT info{};
    info.sType = VK_STRUCTURE_TYPE_SHADER_CREATE_INFO_EXT;
    info.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.codeType = type;
    info.codeSize = code.size();
    info.pCode = code.data();
    info.pName = "main";
    info.pushConstantRangeCount = 1;
    info.pPushConstantRanges = &parameters;
    VkShaderEXT shader = VK_NULL_HANDLE;
    const VkResult result = create_(device_, 1, &info, nullptr, &shader);
    if (type == VK_SHADER_CODE_TYPE_SPIRV_EXT)
        check(result, "vkCreateShadersEXT");
    return result == VK_SUCCESS ? shader : VK_NULL_HANDLE;
}

std::vector<std::byte> ShaderObjects::binary(VkShaderEXT shader) const
{
    size_t bytes = 0;
    check(getBinaryData_(device_, shader, &bytes, nullptr), "vkGetShaderBinaryDataEXT");
    std::vector<std::byte> data(bytes);
    check(getBinaryData_(device_, shader, &bytes, data.data()), "vkGetShaderBinaryDataEXT");
    return data;
}

void ShaderObjects::bind(VkCommandBuffer commands, VkShaderEXT shader) const
{
    const VkShaderStageFlagBits stage = VK_SHADER_STAGE_COMPUTE_BIT;
    cmdBind_(commands, 1, &stage, &shader);
}

}  // namespace restirpg
