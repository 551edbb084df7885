// A compute pipeline.
#pragma once

#include "gpu/device.h"
#include "gpu/shader.h"

namespace restirpg {

/// One compiled compute shader. Its parameters are a struct of at most MAX_PARAMETER_BYTES, given at each dispatch as push constants.
class Kernel {
public:
    Kernel() = default;
    /// `defines` are joined by the device's own (Device::setKernelDefine). Throws Error with the compiler's messages.
    Kernel(Device& device, const std::filesystem::path& file, const Defines& defines = {}, const Includes& includes = {});
    Kernel(Kernel&& other) noexcept { swap(other); }
    Kernel& operator=(Kernel&& other) noexcept
    {
        swap(other);
        return *this;
    }
    ~Kernel();

    VkPipeline pipeline() const { return pipeline_; }
    const LocalSize& groupSize() const { return groupSize_; }
    explicit operator bool() const { return pipeline_ != VK_NULL_HANDLE; }

    /// Bind, set parameters, dispatch enough groups to cover width x height x depth invocations. The descriptor set is bound by the caller.
    void dispatch(VkCommandBuffer commands, const void* parameters, uint32_t parameterBytes, uint32_t width,
                  uint32_t height = 1, uint32_t depth = 1) const;

private:
    void swap(Kernel& other) noexcept;

    Device* device_ = nullptr;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    LocalSize groupSize_;
};

}  // namespace restirpg
