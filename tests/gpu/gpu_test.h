// What GPU tests share: one device with validation on, kernels by file name, one call to run them.
#pragma once

#include "gpu/binding_set.h"
#include "gpu/kernel.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <map>

namespace restirpg::test {

/// The device tests run on: lavapipe, or what RESTIRPG_TEST_DEVICE names.
inline std::string testDevice()
{
    const char* wanted = std::getenv("RESTIRPG_TEST_DEVICE");
    return wanted ? wanted : "llvmpipe";
}

/// The device of this process. A validation message fails the call that caused it.
inline Device& device()
{
    static Device instance(DeviceOptions{.device = testDevice(), .validation = true});
    return instance;
}

/// tests/gpu/NAME.comp, compiled once a process.
inline const Kernel& kernel(const std::string& name)
{
    Device& target = device();  // first: static objects are destroyed in the reverse order of their making
    static std::map<std::string, Kernel> kernels;
    auto found = kernels.find(name);
    if (found == kernels.end())
        found = kernels.emplace(name, Kernel(target, fmt::format("{}/tests/gpu/{}.comp", RESTIRPG_SOURCE, name))).first;
    return found->second;
}

/// Dispatch `threads` invocations of a kernel and wait.
template <typename Parameters>
void run(const std::string& name, const Parameters& parameters, uint32_t threads, const BindingSet* bindings = nullptr)
{
    static_assert(sizeof(Parameters) <= MAX_PARAMETER_BYTES);
    const Kernel& compiled = kernel(name);
    static BindingSet noScene(device());
    device().submit([&](VkCommandBuffer commands) {
        (bindings ? *bindings : noScene).bind(commands);
        compiled.dispatch(commands, &parameters, sizeof(parameters), threads);
    });
}

}  // namespace restirpg::test
