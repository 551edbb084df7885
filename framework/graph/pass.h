// The base class of every pass, and the entry points of a plugin.
#pragma once

#include "core/paths.h"
#include "graph/interface.h"

#include <memory>
#include <string>

namespace restirpg {

class Device;  // gpu/device.h
class Frame;  // render/frame.h

/// Changes whenever a struct or a virtual function that plugins see changes. Checked when a plugin is loaded.
constexpr uint32_t PLUGIN_ABI = 9;

class Pass {
public:
    virtual ~Pass() = default;

    /// Declare ports and knobs. Called once, before anything else; touches no GPU.
    virtual void describe(Interface& io) = 0;

    /// Throw Error where knobs and wiring do not go together; fail() with what to mend, without the pass's name. Called
    /// when a graph is loaded and before every frame, with the ports' `wired` set; touches no GPU.
    virtual void check() const {}

    /// Make kernels (they are compiled side by side, after this returns) and load what does not change with the frame.
    /// Called once, before the first frame. When a structural knob changes, a new instance is described and built and
    /// takes this one's place.
    virtual void build(Device& device) = 0;

    /// Record this frame's dispatches. Barriers between passes and between dispatches are the frame's.
    virtual void record(Frame& frame) = 0;
};

/// What a plugin exports as `restirpgPlugin`.
struct PluginEntry {
    uint32_t abi;
    const char* name;
    const char* meaning;
    std::unique_ptr<Pass> (*create)();
    const char* source = "";  ///< the folder that the pass was built from; see pluginFolder
};

#ifdef RESTIRPG_PASS_FOLDER  // set by restirpg_add_pass
/// A file of this pass, such as its kernel "GBuffer.comp": in the source tree, or where the pass was installed. Static,
/// so that each plugin has its own.
[[maybe_unused]] static std::filesystem::path passFile(const char* name)
{
    static const char here = 0;
    return pluginFolder(&here, RESTIRPG_PASS_FOLDER) / name;
}
#endif

}  // namespace restirpg

/// Export the class `Type` as the plugin of this shared library, with one sentence of what it does.
#define RESTIRPG_PASS(Type, meaning)                                                                                   \
    extern "C" __attribute__((visibility("default"))) const ::restirpg::PluginEntry restirpgPlugin = {                 \
        ::restirpg::PLUGIN_ABI, #Type, meaning,                                                                        \
        []() -> std::unique_ptr<::restirpg::Pass> { return std::make_unique<Type>(); }, RESTIRPG_PASS_FOLDER};
