#include "gpu/features.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <utility>

namespace restirpg {
namespace {

/// A feature every kernel relies on.
struct Required {
    const char* name;
    VkBool32 (*get)(const Features&);
    void (*enable)(Features&);
};

#define RESTIRPG_FEATURE(structure, field)                                                                             \
    {                                                                                                                  \
#field, [](const Features& f) -> VkBool32 { return f.structure.field; },                                       \
                                                                              [](Features &                            \
                                                                                 f) { f.structure.field = VK_TRUE; }   \
    }

const std::vector<Required>& requiredFeatures()
{
    static const std::vector<Required> features = {
        RESTIRPG_FEATURE(core.features, shaderInt64),
        RESTIRPG_FEATURE(vulkan12, bufferDeviceAddress),
        RESTIRPG_FEATURE(vulkan12, shaderBufferInt64Atomics),
        RESTIRPG_FEATURE(vulkan12, scalarBlockLayout),
    };
    return features;
}

bool hasExtensions(VkPhysicalDevice physical, const std::vector<const char*>& names)
{
    uint32_t count = 0;
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> properties(count);
    vkEnumerateDeviceExtensionProperties(physical, nullptr, &count, properties.data());
    return std::all_of(names.begin(), names.end(), [&](const char* name) {
        return std::any_of(properties.begin(), properties.end(),
                           [&](const auto& property) { return std::strcmp(property.extensionName, name) == 0; });
    });
}

std::string typeName(VkPhysicalDeviceType type)
{
    switch (type) {
    case VK_PHYSICAL_DEVICE_TYPE_DISCRETE_GPU:
        return "discrete GPU";
    case VK_PHYSICAL_DEVICE_TYPE_INTEGRATED_GPU:
        return "integrated GPU";
    case VK_PHYSICAL_DEVICE_TYPE_VIRTUAL_GPU:
        return "virtual GPU";
    case VK_PHYSICAL_DEVICE_TYPE_CPU:
        return "CPU";
    default:
        return "other";
    }
}

/// lavapipe before Mesa 25 crashes in kernels that use device addresses in earnest (measured: 22.3.6). Its
/// driverVersion is always 0.0.1; the version stands in driverInfo, "Mesa 25.0.7 ...".
bool isOldLavapipe(const VkPhysicalDeviceDriverProperties& driver)
{
    int major = 0;
    return driver.driverID == VK_DRIVER_ID_MESA_LLVMPIPE && std::sscanf(driver.driverInfo, "Mesa %d", &major) == 1 &&
           major < 25;
}

}  // namespace

Features::Features()
{
    core.pNext = &vulkan11;
    vulkan11.pNext = &vulkan12;
}

void Features::chainRayQuery()
{
    rayQuery.pNext = std::exchange(core.pNext, &accelerationStructure);
    accelerationStructure.pNext = &rayQuery;
}

void Features::chainShaderObject()
{
    shaderObject.pNext = std::exchange(core.pNext, &shaderObject);
}

const std::vector<const char*>& rayQueryExtensions()
{
    static const std::vector<const char*> names = {VK_KHR_ACCELERATION_STRUCTURE_EXTENSION_NAME,
                                                   VK_KHR_DEFERRED_HOST_OPERATIONS_EXTENSION_NAME,
                                                   VK_KHR_RAY_QUERY_EXTENSION_NAME};
    return names;
}

DeviceDescription describeDevice(VkPhysicalDevice physical)
{
    VkPhysicalDeviceDriverProperties driver{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_DRIVER_PROPERTIES};
    VkPhysicalDeviceProperties2 properties{VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PROPERTIES_2, &driver};
    vkGetPhysicalDeviceProperties2(physical, &properties);
    DeviceDescription description;
    description.name = properties.properties.deviceName;
    description.driver = fmt::format("{} {}", driver.driverName, driver.driverInfo);
    description.type = typeName(properties.properties.deviceType);

    if (properties.properties.apiVersion < VK_API_VERSION_1_2) {
        description.missing.push_back("Vulkan 1.2");
        return description;
    }
    Features features;
    if (hasExtensions(physical, rayQueryExtensions()))
        features.chainRayQuery();
    if (hasExtensions(physical, {VK_EXT_SHADER_OBJECT_EXTENSION_NAME}))
        features.chainShaderObject();
    vkGetPhysicalDeviceFeatures2(physical, &features.core);
    description.rayQuery = features.accelerationStructure.accelerationStructure && features.rayQuery.rayQuery;
    description.shaderObject = features.shaderObject.shaderObject;
    for (const auto& feature : requiredFeatures())
        if (!feature.get(features))
            description.missing.push_back(feature.name);
    if (isOldLavapipe(driver))
        description.missing.push_back("Mesa 25 or newer");
    return description;
}

void enableFeatures(Features& features, bool rayQuery, bool shaderObject)
{
    for (const auto& feature : requiredFeatures())
        feature.enable(features);
    if (rayQuery) {
        features.chainRayQuery();
        features.accelerationStructure.accelerationStructure = VK_TRUE;
        features.rayQuery.rayQuery = VK_TRUE;
    }
    if (shaderObject) {
        features.chainShaderObject();
        features.shaderObject.shaderObject = VK_TRUE;
    }
}

}  // namespace restirpg
