#include "graph/plugins.h"

#include "core/nearest.h"
#include "core/paths.h"

#include <dlfcn.h>
#include <fmt/ranges.h>

#include <cstdlib>
#include <sstream>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

const std::string PREFIX = "restirpg-pass-";

std::vector<fs::path> standardFolders()
{
    std::vector<fs::path> folders;
    if (const char* given = std::getenv("RESTIRPG_PLUGIN_PATH")) {
        std::istringstream list(given);
        for (std::string folder; std::getline(list, folder, ':');)
            if (!folder.empty())
                folders.emplace_back(fs::absolute(folder));
    }
    folders.push_back(libraryFolder() / "restirpg/passes");
    return folders;
}

/// Load the library and check its entry. Throws Error naming the library and the mend.
const PluginEntry* load(const fs::path& library, const std::string& name)
{
    // A plugin's code and type information are used until the end: its library is never closed.
    void* handle = dlopen(library.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!handle)
        fail("{}; rebuild the pass against this framework", dlerror());
    const auto* entry = static_cast<const PluginEntry*>(dlsym(handle, "restirpgPlugin"));
    if (!entry)
        fail("{}: it exports no pass; its source must end with RESTIRPG_PASS({}, \"...\")", library.string(), name);
    if (entry->abi != PLUGIN_ABI)
        fail("{}: built for plugin ABI {}, this framework has {}; rebuild the pass", library.string(), entry->abi,
             PLUGIN_ABI);
    for (const auto& [there, what] : {std::pair(entry->name != nullptr, "a name"),
                                      {entry->meaning != nullptr, "a meaning"},
                                      {entry->create != nullptr, "a function that creates the pass"},
                                      {entry->source != nullptr, "the folder of its source"}})
        if (!there)
            fail("{}: its entry lacks {}; end its source with RESTIRPG_PASS({}, \"...\")", library.string(), what,
                 name);
    if (entry->name != name)
        fail("{}: it contains the pass '{}'; name the file {}{}.so", library.string(), entry->name, PREFIX,
             entry->name);
    return entry;
}

}  // namespace

std::pair<std::unique_ptr<Pass>, Interface> instantiate(const PluginEntry& entry)
{
    std::pair<std::unique_ptr<Pass>, Interface> made;
    runPlugin("cannot be created: ", [&] { made.first = entry.create(); });
    if (!made.first)
        fail("cannot be created: its plugin gave none");
    runPlugin("describes itself wrongly: ", [&] { made.first->describe(made.second); });
    return made;
}

Plugins::Plugins() : folders_(standardFolders())
{
    for (const auto& folder : folders_)
        scan(folder);
}

Plugins::Plugins(const std::vector<const PluginEntry*>& entries)
{
    for (const auto* entry : entries)
        plugins_[entry->name] = {entry, {}};
}

void Plugins::scan(const fs::path& folder)
{
    std::error_code unreadable;  // a folder that is not there holds no passes
    for (const auto& file : fs::directory_iterator(folder, unreadable)) {
        const std::string stem = file.path().stem().string();
        if (file.path().extension() == ".so" && stem.starts_with(PREFIX))
            plugins_.try_emplace(stem.substr(PREFIX.size()), Plugin{nullptr, file.path()});
    }
}

std::vector<std::string> Plugins::names() const
{
    std::vector<std::string> result;
    for (const auto& [name, plugin] : plugins_)
        result.push_back(name);
    return result;
}

std::string Plugins::searched() const
{
    std::string text;
    for (const auto& folder : folders_)
        text += (text.empty() ? "" : ", ") + folder.string();
    return text;
}

const Plugin* Plugins::find(const std::string& name) const
{
    const auto found = plugins_.find(name);
    if (found == plugins_.end() || problems_.contains(name))
        return nullptr;
    if (!found->second.entry) {
        try {
            found->second.entry = load(found->second.library, name);
        } catch (const Error& error) {
            problems_[name] = error.what();
            return nullptr;
        }
    }
    return &found->second;
}

const Plugin& Plugins::get(const std::string& name) const
{
    if (const Plugin* plugin = find(name))
        return *plugin;
    if (const auto text = problem(name); !text.empty())
        fail("{}", text);
    const auto guess = didYouMean(name, names());
    failAs<WrongValue>("there is no pass type '{}'; pass types: {}{}{}", name, fmt::join(names(), ", "),
                       guess.empty() ? "" : "; ", guess);
}

std::vector<fs::path> Plugins::code() const
{
    std::vector<fs::path> paths;
    for (const auto& name : names())
        if (const Plugin* plugin = find(name)) {
            paths.push_back(plugin->library);
            paths.push_back(pluginFolder(plugin->entry, plugin->entry->source));
        }
    return paths;
}

std::string Plugins::problem(const std::string& name) const
{
    const auto found = problems_.find(name);
    return found == problems_.end() ? std::string() : found->second;
}

}  // namespace restirpg
