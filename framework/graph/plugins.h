// Finding and loading passes.
#pragma once

#include "core/error_kinds.h"
#include "graph/pass.h"

#include <filesystem>
#include <map>
#include <memory>
#include <new>
#include <string>
#include <utility>
#include <vector>

namespace restirpg {

/// A loaded plugin. Its library stays loaded until the process ends.
struct Plugin {
    const PluginEntry* entry = nullptr;
    std::filesystem::path library;  ///< empty for a pass of this process
};

/// A new pass and what it declares. Throws Error, without the pass's name, when the plugin's code does.
std::pair<std::unique_ptr<Pass>, Interface> instantiate(const PluginEntry& entry);

/// Run code of a plugin: whatever it throws arrives as an Error that begins with `label` and names what was asked of
/// it, but for std::bad_alloc, which stays.
template <typename Action>
auto runPlugin(const std::string& label, Action action)
{
    try {
        return action();
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const WrongValue& error) {
        throw WrongValue(label + error.what());
    } catch (const Error& error) {
        throw Error(label + error.what());  // which may be several lines
    } catch (const std::exception& error) {
        throw Error(label + escaped(error.what()));
    } catch (...) {
        throw Error(label + "it threw something that is not a std::exception");
    }
}

/// Every pass at hand: `restirpg-pass-NAME.so` beside the framework and along RESTIRPG_PLUGIN_PATH (colon separated,
/// searched first). The file name gives the pass's name; a library is loaded when its pass is first asked for, so that
/// a broken one spoils no other.
class Plugins {
public:
    /// Scan the standard folders.
    Plugins();
    /// Passes of this process, for tests that need no shared library. Two must not have the same name.
    explicit Plugins(const std::vector<const PluginEntry*>& entries);

    std::vector<std::string> names() const;  ///< sorted; some may turn out not to load
    std::string searched() const;  ///< the folders, in the order they are searched, for messages

    /// Loads the pass's library if need be. nullptr when there is no such pass or it cannot be loaded: see problem().
    const Plugin* find(const std::string& name) const;
    /// As find(). Throws Error where the pass cannot be loaded, WrongValue naming the passes there are where it is
    /// none.
    const Plugin& get(const std::string& name) const;
    /// What pictures depend on besides the framework itself: of each pass in the order of names(), its library, then
    /// the folder of its kernels. Loads them all; what does not load is left out, for it cannot render.
    std::vector<std::filesystem::path> code() const;
    /// Why a pass that was found could not be loaded, naming its library and the mend; empty when nothing went wrong.
    std::string problem(const std::string& name) const;

private:
    void scan(const std::filesystem::path& folder);

    std::vector<std::filesystem::path> folders_;
    mutable std::map<std::string, Plugin> plugins_;
    mutable std::map<std::string, std::string> problems_;
};

}  // namespace restirpg
