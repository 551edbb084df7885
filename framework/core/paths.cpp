#include "core/paths.h"

#include <dlfcn.h>

#include <cstdlib>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

fs::path environment(const char* name)
{
    const char* value = std::getenv(name);
    return value ? fs::path(value) : fs::path();
}

/// share/restirpg of the installed tree, or empty.
fs::path shareFolder()
{
    const fs::path share = libraryFolder() / "../share/restirpg";
    return fs::exists(share) ? fs::weakly_canonical(share) : fs::path();
}

}  // namespace

fs::path libraryFolder()
{
    Dl_info info;
    if (dladdr(reinterpret_cast<const void*>(&libraryFolder), &info) && info.dli_fname)
        return fs::weakly_canonical(info.dli_fname).parent_path();
    return fs::current_path();
}

fs::path shaderFolder()
{
    if (const auto given = environment("RESTIRPG_SHADERS"); !given.empty())
        return given;
    if (const auto share = shareFolder(); !share.empty())
        return share / "shaders";
    return fs::path(RESTIRPG_SOURCE_FRAMEWORK) / "shaders";
}

fs::path pythonFolder()
{
    if (const auto share = shareFolder(); !share.empty())
        return share / "python";
    return fs::path(RESTIRPG_SOURCE_FRAMEWORK) / "python";
}

fs::path displayConfig()
{
    if (const auto share = shareFolder(); !share.empty())
        return share / "default.ocio";
    return fs::path(RESTIRPG_SOURCE_FRAMEWORK) / "image/default.ocio";
}

fs::path pluginFolder(const void* inside, const fs::path& source)
{
    Dl_info info;
    if (!dladdr(inside, &info) || !info.dli_fname)
        return source;
    const fs::path installed = fs::weakly_canonical(info.dli_fname).replace_extension();
    return fs::exists(installed) ? installed : source;
}

fs::path pythonInterpreter()
{
    const auto given = environment("RESTIRPG_PYTHON");
    return given.empty() ? fs::path(RESTIRPG_PYTHON) : given;
}

fs::path cacheFolder()
{
    if (const auto given = environment("RESTIRPG_CACHE_DIR"); !given.empty())
        return given;
    if (const auto xdg = environment("XDG_CACHE_HOME"); !xdg.empty())
        return xdg / "restirpg";
    const auto home = environment("HOME");
    return home.empty() ? home : home / ".cache/restirpg";
}

}  // namespace restirpg
