// One pass alone on the device: buffers of the test's own at its ports, no graph, no scene.
#pragma once

#include "gpu/device.h"
#include "graph/plugins.h"
#include "render/frame.h"
#include "shaders/frame_types.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>
#include <vector>

namespace restirpg {

class PassHarness {
public:
    /// Loads the plugin `type` for images of width x height pixels. The validation layer is on.
    PassHarness(const std::string& type, uint32_t width, uint32_t height)
        : width_(width), height_(height), device_(DeviceOptions{.device = "", .backend = "", .validation = true})
    {
        const Plugin* plugin = plugins_.find(type);
        if (!plugin)
            fail("no pass {}: {}", type, plugins_.problem(type));
        pass_ = plugin->entry->create();
        pass_->describe(interface_);
        constants_ = device_.createBuffer(sizeof(FrameConstants), "frame constants");
        FrameConstants constants{};
        constants.size = {width_, height_};
        device_.upload(constants_, &constants, sizeof constants);
    }

    /// A zeroed buffer of the port's size.
    Buffer makeBuffer(const std::string& port)
    {
        for (const InputPort& input : interface_.inputs())
            if (input.name == port)
                return device_.createBuffer(input.type.bytes(width_, height_), port);
        for (const OutputPort& output : interface_.outputs())
            if (output.name == port)
                return device_.createBuffer(output.type.bytes(width_, height_), port);
        fail("the pass has no port '{}'", port);
    }

    /// What the port reads or writes from now on; null unwires it.
    void connect(const std::string& port, Buffer* buffer)
    {
        for (const InputPort& input : interface_.inputs())
            if (input.name == port) {
                input.target->resource = buffer;
                input.target->wired = buffer != nullptr;
            }
        for (const OutputPort& output : interface_.outputs())
            if (output.name == port) {
                output.target->resource = buffer;
                output.target->wired = buffer != nullptr;
            }
    }

    void setKnob(const std::string& name, const nlohmann::json& value)
    {
        for (Knob& knob : interface_.knobs())
            if (knob.name == name)
                knob.set(value);
    }

    void build() { pass_->build(device_); }

    /// Record `frames` frames into one command buffer and run it. `prepare(frame)` may connect ports.
    void run(
        uint32_t frames, const std::function<void(uint32_t)>& prepare = [](uint32_t) {})
    {
        device_.submit([&](VkCommandBuffer commands) {
            for (uint32_t index = 0; index < frames; ++index) {
                prepare(index);
                Frame frame(device_, commands, constants_.address(), width_, height_, index, index == 0);
                pass_->record(frame);
            }
        });
    }

    template <typename T>
    std::vector<T> download(const Buffer& buffer)
    {
        return device_.download<T>(buffer, buffer.bytes() / sizeof(T));
    }

    Device& device() { return device_; }

private:
    uint32_t width_, height_;
    Plugins plugins_;
    Device device_;
    std::unique_ptr<Pass> pass_;
    Interface interface_;
    Buffer constants_;
};

}  // namespace restirpg
