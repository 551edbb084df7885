// Which Vulkan features restirpg needs, asked for and checked in one place.
#pragma once

#include "gpu/device.h"
#include "gpu/shader_object.h"

namespace restirpg {

/// The chain of feature structs. Not copyable: the members point at each other.
struct Features {
    Features();
    Features(const Features&) = delete;
    Features& operator=(const Features&) = delete;

    VkPhysicalDeviceFeatures2 core{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_FEATURES_2};
    VkPhysicalDeviceVulkan11Features vulkan11{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_1_FEATURES};
    VkPhysicalDeviceVulkan12Features vulkan12{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_VULKAN_1_2_FEATURES};
    VkPhysicalDeviceAccelerationStructureFeaturesKHR accelerationStructure{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_ACCELERATION_STRUCTURE_FEATURES_KHR};
    VkPhysicalDeviceRayQueryFeaturesKHR rayQuery{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_RAY_QUERY_FEATURES_KHR};
    VkPhysicalDeviceShaderObjectFeaturesEXT shaderObject{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_SHADER_OBJECT_FEATURES_EXT,
                                                         nullptr, VK_FALSE};

    /// Link the ray query structs into the chain.
    void chainRayQuery();
    void chainShaderObject();
};

/// Name, driver, type, support of extensions and missing features of a physical device.
DeviceDescription describeDevice(VkPhysicalDevice physical);

/// Turn on exactly what restirpg needs (describeDevice said it is there).
void enableFeatures(Features& features, bool rayQuery, bool shaderObject);

/// Device extensions of the ray query back end.
const std::vector<const char*>& rayQueryExtensions();

}  // namespace restirpg
