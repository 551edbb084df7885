// A compute kernel: its pipeline, compiled in a thread of its own.
#pragma once

#include "gpu/device.h"

namespace restirpg {

enum class Compile {
    now,
    atFirstDispatch,  ///< for kernels that the knobs, as they stand, do not ask for
};

inline Compile compileIf(bool wanted)
{
    return wanted ? Compile::now : Compile::atFirstDispatch;
}

/// One compute shader. Its parameters are a struct of at most MAX_PARAMETER_BYTES, given at each dispatch as push
/// constants.
class Kernel {
public:
    Kernel() = default;
    /// Begins to compile and returns at once. `defines` are joined by the device's own (Device::setKernelDefine).
    /// Device::finishKernels, or else the first dispatch, waits for the end and throws Error with the compiler's
    /// messages. The logical device must outlive it.
    Kernel(Device& device, const std::filesystem::path& file, const Defines& defines = {},
           const Includes& includes = {}, Compile when = Compile::now);

    explicit operator bool() const { return pipeline_.valid(); }
    /// Waits until it is compiled.
    const Pipeline& pipeline() const;

    /// Bind, set parameters, dispatch enough groups to cover width x height x depth invocations. The descriptor set is
    /// bound by the caller.
    void dispatch(VkCommandBuffer commands, const void* parameters, uint32_t parameterBytes, uint32_t width,
                  uint32_t height = 1, uint32_t depth = 1) const;

private:
    void compile(std::launch policy) const;

    Device* device_ = nullptr;
    std::filesystem::path file_;
    Defines defines_;
    Includes includes_;
    // Compiled with the device's defines as they are: pipeline() follows them.
    mutable std::shared_future<std::shared_ptr<const Pipeline>> pipeline_;
    mutable uint32_t generation_ = 0;
};

}  // namespace restirpg
