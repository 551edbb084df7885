#include "gpu/device_choice.h"

#include "core/error_kinds.h"

#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>

namespace restirpg {
namespace {

/// Lower is better, among devices the user did not choose between.
int rank(const DeviceDescription& description)
{
    const std::vector<std::string> order = {"discrete GPU", "integrated GPU", "virtual GPU", "CPU"};
    const int place = int(std::find(order.begin(), order.end(), description.type) - order.begin());
    return place + (description.missing.empty() ? 0 : 100);
}

/// By its number, else by a part of its name; the number of devices when there is none.
size_t findDevice(const std::vector<DeviceDescription>& devices, const std::string& wanted)
{
    if (wanted.find_first_not_of("0123456789") == wanted.npos) {
        size_t index = devices.size();
        std::from_chars(wanted.data(), wanted.data() + wanted.size(), index);  // of a number too large it stays
        return std::min(index, devices.size());
    }
    const auto isNamed = [&](const auto& device) { return device.name.find(wanted) != device.name.npos; };
    return size_t(std::find_if(devices.begin(), devices.end(), isNamed) - devices.begin());
}

}  // namespace

size_t chooseDevice(const std::vector<DeviceDescription>& devices, const std::string& wanted)
{
    if (devices.empty())
        fail("no Vulkan device found; install a driver (for the CPU: mesa-vulkan-drivers >= 25)");
    if (wanted.empty())
        return size_t(std::min_element(devices.begin(), devices.end(),
                                       [](const auto& a, const auto& b) { return rank(a) < rank(b); }) -
                      devices.begin());
    const size_t found = findDevice(devices, wanted);
    if (found == devices.size())
        failAs<WrongValue>("no device '{}'; `restirpg devices` lists those at hand by number and name", wanted);
    return found;
}

Backend chooseBackend(const DeviceDescription& device, const std::string& wanted)
{
    if (wanted == nameOf(Backend::software))
        return Backend::software;
    if (wanted == nameOf(Backend::rayQuery)) {
        if (!device.rayQuery)
            fail("device '{}' ({}) has no ray query (VK_KHR_ray_query); use the back end 'software'", device.name,
                 device.driver);
        return Backend::rayQuery;
    }
    if (!wanted.empty())
        failAs<WrongValue>("no back end '{}'; there are 'software' and 'rayquery'", wanted);
    // Measured: our own traversal is 2.3 to 3.6 times as fast as ray query where the device is a CPU.
    return device.rayQuery && !device.isCpu() ? Backend::rayQuery : Backend::software;
}

/// On lavapipe, where they make a start faster. Drivers of GPUs keep compiled pipelines themselves. Not where the
/// validation layer may be on, by us or by the loader's variables: before 1.3.246 it takes a dispatch of a shader
/// object for one without a kernel.
bool usesShaderObjects(const DeviceDescription& device, Backend backend, bool validated)
{
    return device.shaderObject && device.isCpu() && backend == Backend::software && !validated &&
           !std::getenv("VK_INSTANCE_LAYERS") && !std::getenv("VK_LOADER_LAYERS_ENABLE");
}

void refuseIncomplete(const DeviceDescription& device)
{
    if (device.missing.empty())
        return;
    fail("device '{}' ({}) lacks {}; update its driver, choose another device (`restirpg devices`), or install "
         "mesa-vulkan-drivers >= 25 to render on the CPU",
         device.name, device.driver, fmt::join(device.missing, ", "));
}

}  // namespace restirpg
