#include "gpu/logical_device.h"

#include "core/error_kinds.h"
#include "core/log.h"
#include "core/memory.h"
#include "gpu/features.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <map>
#include <tuple>

#include <unistd.h>

namespace restirpg {
namespace {

VKAPI_ATTR VkBool32 VKAPI_CALL onValidationMessage(VkDebugUtilsMessageSeverityFlagBitsEXT,
                                                   VkDebugUtilsMessageTypeFlagsEXT,
                                                   const VkDebugUtilsMessengerCallbackDataEXT* data, void* device)
{
    // The layer waits 10 s at most for a thread of its own to note that a fence was signalled: on a full machine that
    // is no mistake.
    if (data->pMessageIdName && std::strcmp(data->pMessageIdName, "UNASSIGNED-VkFence-state-timeout") == 0)
        return VK_FALSE;
    static_cast<LogicalDevice*>(device)->addMessage(data->pMessage);
    logInfo(fmt::format("validation: {}", data->pMessage));
    return VK_FALSE;
}

bool wantsValidation(const DeviceOptions& options)
{
    const char* variable = std::getenv("RESTIRPG_VALIDATION");
    return options.validation || (variable && std::strcmp(variable, "0") != 0 && *variable);
}

bool hasLayer(const char* name)
{
    uint32_t count = 0;
    vkEnumerateInstanceLayerProperties(&count, nullptr);
    std::vector<VkLayerProperties> layers(count);
    vkEnumerateInstanceLayerProperties(&count, layers.data());
    return std::any_of(layers.begin(), layers.end(),
                       [&](const auto& layer) { return std::strcmp(layer.layerName, name) == 0; });
}

bool hasExtension(const char* name)
{
    uint32_t count = 0;
    vkEnumerateInstanceExtensionProperties(nullptr, &count, nullptr);
    std::vector<VkExtensionProperties> extensions(count);
    vkEnumerateInstanceExtensionProperties(nullptr, &count, extensions.data());
    return std::any_of(extensions.begin(), extensions.end(),
                       [&](const auto& extension) { return std::strcmp(extension.extensionName, name) == 0; });
}

/// Mesa crashes where an allocation of its own fails, as it starts or compiles. On two cores a picture of 24x16
/// took 1.1 GiB of address space by path_tracer.py, 1.5 GiB by restir_pt.py.
void refuseTightLimit()
{
    constexpr uint64_t LEAST = uint64_t(2) << 30;
    if (const uint64_t left = addressSpaceLeft(); left < LEAST)
        fail("`ulimit -v` leaves the program {} of address space, and a Vulkan driver may need {}; raise that limit",
             bytesText(left), bytesText(LEAST));
}

/// lavapipe traces rays and compiles kernels faster with four lanes per vector than with eight
/// (benchmarks/results/speed): fewer lanes wait for the longest path. It reads this variable once, when the first
/// device is looked for; a value of the user's own stays.
void preferNarrowVectors()
{
    setenv("LP_NATIVE_VECTOR_WIDTH", "128", 0);
}

void loadVulkan()
{
    preferNarrowVectors();
    static const bool roomy = (refuseTightLimit(), true);  // once: the first device's own memory must not count
    (void)roomy;
    static const VkResult result = volkInitialize();
    if (result != VK_SUCCESS)
        fail("no Vulkan loader on this machine; install libvulkan1 and a driver (for the CPU: mesa-vulkan-drivers >= "
             "25)");
}

VkInstance createInstance(bool validation, VkDebugUtilsMessengerCreateInfoEXT& messenger)
{
    loadVulkan();
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.pApplicationName = "restirpg";
    application.apiVersion = VK_API_VERSION_1_2;
    VkInstanceCreateInfo info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    info.pApplicationInfo = &application;

    const char* layer = "VK_LAYER_KHRONOS_validation";
    const char* debugUtils = VK_EXT_DEBUG_UTILS_EXTENSION_NAME;
    const VkValidationFeatureEnableEXT enabled[] = {VK_VALIDATION_FEATURE_ENABLE_SYNCHRONIZATION_VALIDATION_EXT};
    VkValidationFeaturesEXT features{VK_STRUCTURE_TYPE_VALIDATION_FEATURES_EXT, &messenger};
    features.enabledValidationFeatureCount = 1;
    features.pEnabledValidationFeatures = enabled;
    if (validation) {
        if (!hasLayer(layer))
            fail("validation was asked for, but {} is not on this machine; install vulkan-validationlayers", layer);
        info.ppEnabledLayerNames = &layer;
        info.enabledLayerCount = 1;
        info.pNext = &features;
    }
    // In every instance, since volk holds one pointer a function for the whole process. The loader itself provides it.
    if (hasExtension(debugUtils)) {
        info.ppEnabledExtensionNames = &debugUtils;
        info.enabledExtensionCount = 1;
    }
    VkInstance instance;
    const VkResult result = vkCreateInstance(&info, nullptr, &instance);
    if (result == VK_ERROR_INCOMPATIBLE_DRIVER)
        fail("no Vulkan driver on this machine; install one (for the CPU: mesa-vulkan-drivers >= 25)");
    check(result, "vkCreateInstance");
    volkLoadInstance(instance);
    return instance;
}

std::vector<VkPhysicalDevice> enumerateDevices(VkInstance instance)
{
    uint32_t count = 0;
    check(vkEnumeratePhysicalDevices(instance, &count, nullptr), "vkEnumeratePhysicalDevices");
    std::vector<VkPhysicalDevice> devices(count);
    check(vkEnumeratePhysicalDevices(instance, &count, devices.data()), "vkEnumeratePhysicalDevices");
    return devices;
}

std::vector<VkQueueFamilyProperties> queueFamilies(VkPhysicalDevice physical)
{
    uint32_t count = 0;
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, nullptr);
    std::vector<VkQueueFamilyProperties> families(count);
    vkGetPhysicalDeviceQueueFamilyProperties(physical, &count, families.data());
    return families;
}

uint32_t computeQueueFamily(VkPhysicalDevice physical)
{
    const auto families = queueFamilies(physical);
    for (uint32_t i = 0; i < families.size(); ++i)
        if ((families[i].queueFlags & VK_QUEUE_COMPUTE_BIT) && families[i].timestampValidBits > 0)
            return i;
    fail("the device has no compute queue with timestamps; choose another (`restirpg devices`)");
}

VkDevice createLogicalDevice(VkPhysicalDevice physical, uint32_t family, bool rayQuery, bool shaderObjects)
{
    Features features;
    enableFeatures(features, rayQuery, shaderObjects);
    std::vector<const char*> extensions;
    if (rayQuery)
        extensions = rayQueryExtensions();
    if (shaderObjects)
        extensions.push_back(VK_EXT_SHADER_OBJECT_EXTENSION_NAME);
    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueFamilyIndex = family;
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, &features.core};
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = uint32_t(extensions.size());
    info.ppEnabledExtensionNames = extensions.data();
    VkDevice device;
    check(vkCreateDevice(physical, &info, nullptr, &device), "vkCreateDevice");
    return device;
}

/// The logical devices of a process. Those of a process that forked are left to the parent: a driver's state does not
/// survive a fork.
struct Registry {
    std::mutex mutex;
    std::map<std::tuple<pid_t, std::string, std::string, bool>, std::shared_ptr<LogicalDevice>> devices;
};

Registry& registry()
{
    static Registry* const made = new Registry;  // emptied by release(), never destroyed
    return *made;
}

/// Called at exit, before the driver's own clean-up, which was registered earlier.
void release()
{
    auto devices = std::move(registry().devices);
    std::erase_if(devices, [](const auto& entry) { return std::get<0>(entry.first) == getpid(); });
    new auto(std::move(devices));  // what is a parent's stays untouched
}

/// Drivers, the builder of hierarchies and their threads are not in a process that was forked after they came to life:
/// it would wait for them without end.
void refuseForked()
{
    static const pid_t first = getpid();
    if (getpid() != first)
        fail("Vulkan cannot be used in a process that was forked after its first use; start processes by "
             "multiprocessing.get_context(\"spawn\")");
}

}  // namespace

void check(VkResult result, const char* call)
{
    if (result >= VK_SUCCESS)
        return;
    if (result == VK_ERROR_OUT_OF_DEVICE_MEMORY || result == VK_ERROR_OUT_OF_HOST_MEMORY)
        fail("the device is out of memory ({}); render a smaller image or a smaller scene", call);
    if (result == VK_ERROR_DEVICE_LOST)
        fail(
            "the device is lost ({}): its driver failed, or ended work that took too long; make another renderer, of a "
            "smaller size or window",
            call);
    fail(
        "the Vulkan driver failed: {} gave VkResult {}; give the program more memory (ulimit -v), or update the driver",
        call, int(result));
}

std::vector<DeviceDescription> listDevices()
{
    refuseForked();
    VkDebugUtilsMessengerCreateInfoEXT unused{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    VkInstance instance = createInstance(false, unused);
    std::vector<DeviceDescription> descriptions;
    for (VkPhysicalDevice physical : enumerateDevices(instance))
        descriptions.push_back(describeDevice(physical));
    vkDestroyInstance(instance, nullptr);
    return descriptions;
}

std::shared_ptr<LogicalDevice> LogicalDevice::get(const DeviceOptions& options)
{
    refuseForked();
    auto& known = registry();
    std::lock_guard lock(known.mutex);
    auto& device = known.devices[{getpid(), options.device, options.backend, wantsValidation(options)}];
    if (!device || device->lost_) {
        device = std::make_shared<LogicalDevice>(options);
        static const int registered = std::atexit(release);
        (void)registered;
    }
    return device;
}

LogicalDevice::LogicalDevice(const DeviceOptions& options) : validated_(wantsValidation(options))
{
    try {
        create(options);
    } catch (...) {
        destroy();
        throw;
    }
}

LogicalDevice::LogicalDevice(const LogicalDevice& original)
    : description_(original.description_), backend_(original.backend_),
      physical_(original.plainInstance_ ? original.plainPhysical_ : original.physical_),
      queueFamily_(original.queueFamily_)
{
    createDevice(bool(original.shaderObjects_));
}

LogicalDevice::~LogicalDevice()
{
    destroy();
}

void LogicalDevice::create(const DeviceOptions& options)
{
    VkDebugUtilsMessengerCreateInfoEXT messenger{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
    messenger.messageSeverity =
        VK_DEBUG_UTILS_MESSAGE_SEVERITY_WARNING_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_SEVERITY_ERROR_BIT_EXT;
    messenger.messageType =
        VK_DEBUG_UTILS_MESSAGE_TYPE_VALIDATION_BIT_EXT | VK_DEBUG_UTILS_MESSAGE_TYPE_PERFORMANCE_BIT_EXT;
    messenger.pfnUserCallback = onValidationMessage;
    messenger.pUserData = this;
    if (validated_) {
        VkDebugUtilsMessengerCreateInfoEXT unused{VK_STRUCTURE_TYPE_DEBUG_UTILS_MESSENGER_CREATE_INFO_EXT};
        plainInstance_ = createInstance(false, unused);
    }
    instance_ = createInstance(validated_, messenger);
    if (validated_)
        check(vkCreateDebugUtilsMessengerEXT(instance_, &messenger, nullptr, &messenger_),
              "vkCreateDebugUtilsMessengerEXT");

    const auto devices = enumerateDevices(instance_);
    std::vector<DeviceDescription> descriptions;
    for (VkPhysicalDevice physical : devices)
        descriptions.push_back(describeDevice(physical));
    const size_t index = chooseDevice(descriptions, options.device);
    description_ = descriptions[index];
    physical_ = devices[index];
    if (plainInstance_)
        plainPhysical_ = enumerateDevices(plainInstance_).at(index);
    refuseIncomplete(description_);
    backend_ = chooseBackend(description_, options.backend);
    queueFamily_ = computeQueueFamily(physical_);
    createDevice(usesShaderObjects(description_, backend_, validated_));
}

void LogicalDevice::createDevice(bool shaderObjects)
{
    device_ = createLogicalDevice(physical_, queueFamily_, backend_ == Backend::rayQuery, shaderObjects);
    vkGetDeviceQueue(device_, queueFamily_, 0, &queue_);
    if (shaderObjects)
        shaderObjects_ = ShaderObjects(device_);
    createLayouts();
}

void LogicalDevice::destroy()
{
    pipelines_.clear();
    if (device_) {
        vkDestroyPipelineLayout(device_, pipelineLayout_, nullptr);
        vkDestroyDescriptorSetLayout(device_, setLayout_, nullptr);
        vkDestroyDevice(device_, nullptr);
    }
    if (messenger_)
        vkDestroyDebugUtilsMessengerEXT(instance_, messenger_, nullptr);
    for (VkInstance instance : {instance_, plainInstance_})
        if (instance)
            vkDestroyInstance(instance, nullptr);
}

/// One layout for every kernel: the acceleration structure at binding 0 (ray query only), and MAX_PARAMETER_BYTES of
/// push constants.
void LogicalDevice::createLayouts()
{
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(physical_, &properties);
    timestampPeriod_ = properties.limits.timestampPeriod;
    timestampBits_ = queueFamilies(physical_)[queueFamily_].timestampValidBits;

    const VkDescriptorSetLayoutBinding binding{0, VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1,
                                               VK_SHADER_STAGE_COMPUTE_BIT, nullptr};
    VkDescriptorSetLayoutCreateInfo set{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set.bindingCount = backend_ == Backend::rayQuery ? 1 : 0;
    set.pBindings = &binding;
    check(vkCreateDescriptorSetLayout(device_, &set, nullptr, &setLayout_), "vkCreateDescriptorSetLayout");

    const VkPushConstantRange range{VK_SHADER_STAGE_COMPUTE_BIT, 0, MAX_PARAMETER_BYTES};
    VkPipelineLayoutCreateInfo layout{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    layout.setLayoutCount = 1;
    layout.pSetLayouts = &setLayout_;
    layout.pushConstantRangeCount = 1;
    layout.pPushConstantRanges = &range;
    check(vkCreatePipelineLayout(device_, &layout, nullptr, &pipelineLayout_), "vkCreatePipelineLayout");
}

void LogicalDevice::setName(uint64_t handle, VkObjectType type, const std::string& name) const
{
    if (!vkSetDebugUtilsObjectNameEXT)  // the loader lacks the extension
        return;
    VkDebugUtilsObjectNameInfoEXT info{VK_STRUCTURE_TYPE_DEBUG_UTILS_OBJECT_NAME_INFO_EXT};
    info.objectType = type;
    info.objectHandle = handle;
    info.pObjectName = name.c_str();
    vkSetDebugUtilsObjectNameEXT(device_, &info);
}

void LogicalDevice::submit(const VkSubmitInfo& work, VkFence fence)
{
    std::lock_guard lock(queueMutex_);
    checkWork(vkQueueSubmit(queue_, 1, &work, fence), "vkQueueSubmit");
}

void LogicalDevice::checkWork(VkResult result, const char* call)
{
    if (result == VK_ERROR_DEVICE_LOST)
        lost_ = true;
    check(result, call);
}

void LogicalDevice::addMessage(const std::string& message)
{
    std::lock_guard lock(messageMutex_);
    messages_.push_back(message);
}

std::vector<std::string> LogicalDevice::messages(size_t first) const
{
    std::lock_guard lock(messageMutex_);
    return {messages_.begin() + std::ptrdiff_t(std::min(first, messages_.size())), messages_.end()};
}

}  // namespace restirpg
