// Finding and loading passes.
#pragma once

#include "graph/pass.h"

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace restirpg {

/// A loaded plugin. Its library stays loaded until the process ends.
struct Plugin {
    const PluginEntry* entry = nullptr;
    std::filesystem::path library;
};

/// Every pass at hand: `restirpg-pass-NAME.so` beside the framework and along RESTIRPG_PLUGIN_PATH (colon separated, searched
/// first). A library that cannot be loaded, or whose ABI number differs, is named in a warning and an Error when it is asked for.
class Plugins {
public:
    /// Scan the standard folders.
    Plugins();
    /// Passes of this process, for tests that need no shared library.
    explicit Plugins(std::vector<const PluginEntry*> entries);

    std::vector<std::string> names() const;  ///< sorted
    /// nullptr when there is no such pass.
    const Plugin* find(const std::string& name) const;
    /// Why a pass that was found could not be loaded; empty when there is nothing to say.
    std::string problem(const std::string& name) const;

private:
    std::map<std::string, Plugin> plugins_;
    std::map<std::string, std::string> problems_;
};

}  // namespace restirpg
