// What a pass sees while it records its part of a frame.
#pragma once

#include "core/error.h"
#include "gpu/kernel.h"
#include "graph/pass.h"

#include <map>
#include <string>
#include <utility>

namespace restirpg {

/// On a CPU: throws Error, beginning with `place`, where so many bytes of a frame do not fit the memory. A CPU's
/// buffers lie in the machine's memory: who takes too much of it is killed without a word.
void checkFits(const Device& device, const std::string& place, uint32_t width, uint32_t height, uint64_t bytes);

/// Handed to Pass::record. A barrier stands before every dispatch, so each sees what those before it wrote.
class Frame {
public:
    Frame(Device& device, VkCommandBuffer commands, uint64_t constants, uint32_t width, uint32_t height, uint32_t index,
          bool reset)
        : device_(device), commands_(commands), constants_(constants), width_(width), height_(height), index_(index),
          reset_(reset)
    {
    }

    uint32_t width() const { return width_; }  ///< pixels
    uint32_t height() const { return height_; }
    uint32_t index() const { return index_; }  ///< frames since the last cut
    bool reset() const { return reset_; }  ///< first frame after a start or a cut: delayed inputs are zeroed
    uint64_t constants() const { return constants_; }  ///< device address of this frame's FrameConstants

    /// Run `kernel` over width x height x depth invocations (rounded up to whole groups: kernels test their bounds).
    template <typename Parameters>
    void dispatch(const Kernel& kernel, const Parameters& parameters, uint32_t width, uint32_t height = 1,
                  uint32_t depth = 1)
    {
        static_assert(sizeof(Parameters) <= MAX_PARAMETER_BYTES,
                      "parameters are push constants: put large tables in a buffer");
        barrier();
        kernel.dispatch(commands_, &parameters, sizeof(Parameters), width, height, depth);
    }

    /// One invocation per pixel.
    template <typename Parameters>
    void dispatchPixels(const Kernel& kernel, const Parameters& parameters)
    {
        dispatch(kernel, parameters, width_, height_);
    }

    /// The address of a buffer of the pass's own, made anew where it has fewer bytes: for what the pass keeps within a
    /// frame.
    uint64_t scratch(Buffer& buffer, uint64_t bytes, const char* name);

    /// Bytes of the buffers that scratch() was asked for since the last call.
    uint64_t takeScratchBytes();

    /// Copy all of a buffer into another of its size.
    void copy(const Buffer& from, const Buffer& to);

    /// Fill a buffer, or its first `bytes` (a multiple of 4), with a 32-bit word.
    void fill(const Buffer& buffer, uint32_t word = 0, uint64_t bytes = VK_WHOLE_SIZE);

private:
    void barrier();

    Device& device_;
    VkCommandBuffer commands_;
    uint64_t constants_;
    uint32_t width_, height_, index_;
    bool reset_;
    std::map<const Buffer*, uint64_t> scratch_;
};

/// Address of an optional port's buffer: 0 when the port is not wired.
template <typename Port>
uint64_t addressOf(const Port& port)
{
    return port ? port->address() : 0;
}

}  // namespace restirpg
