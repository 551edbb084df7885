#include "core/paths.h"

#include "core/error_kinds.h"

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

fs::path& interpreter()
{
    static fs::path program = RESTIRPG_PYTHON;
    return program;
}

/// share/restirpg of the installed tree, or empty.
fs::path shareFolder()
{
    const fs::path share = libraryFolder() / "../share/restirpg";
    return fs::exists(share) ? fs::weakly_canonical(share) : fs::path();
}

/// The folder `framework` of the source tree, which the build tree finds beside itself.
fs::path sourceFolder()
{
    return fs::weakly_canonical(libraryFolder() / RESTIRPG_SOURCE_FRAMEWORK);
}

}  // namespace

fs::path libraryFolder()
{
    Dl_info info;
    if (dladdr(reinterpret_cast<const void*>(&libraryFolder), &info) && info.dli_fname &&
        fs::path(info.dli_fname).is_absolute())
        return fs::weakly_canonical(info.dli_fname).parent_path();
    // The program itself, by the name that it was started with: that may be relative to a working directory of another
    // time.
    return fs::read_symlink("/proc/self/exe").parent_path();
}

fs::path shaderFolder()
{
    if (auto given = environment("RESTIRPG_SHADERS"); !given.empty())
        return given;
    if (const auto share = shareFolder(); !share.empty())
        return share / "shaders";
    return sourceFolder() / "shaders";
}

fs::path pythonFolder()
{
    const fs::path library = libraryFolder();
    // In the installed tree, in the build tree, in a wheel.
    for (const char* folder : {"../share/restirpg/python", "../python", "../.."})
        if (fs::exists(library / folder / "restirpg/evaluate.py"))
            return fs::weakly_canonical(library / folder);
    fail("{}: the Python package restirpg is not beside this folder: install or configure anew", library.string());
}

fs::path displayConfig()
{
    if (const auto share = shareFolder(); !share.empty())
        return share / "default.ocio";
    return sourceFolder() / "image/default.ocio";
}

fs::path pluginFolder(const void* inside, const fs::path& source)
{
    Dl_info info;
    if (!dladdr(inside, &info) || !info.dli_fname)
        return source;
    const fs::path library = fs::weakly_canonical(info.dli_fname);
    const fs::path installed = fs::path(library).replace_extension();
    return fs::exists(installed) ? installed : fs::weakly_canonical(library.parent_path() / source);
}

void setPythonInterpreter(const fs::path& program)
{
    interpreter() = program;
}

fs::path pythonInterpreter()
{
    const auto given = environment("RESTIRPG_PYTHON");
    return given.empty() ? interpreter() : given;
}

std::vector<std::string> pythonModule(const std::string& module)
{
    return {pythonInterpreter().string(), "-P", "-m", module};
}

std::string pythonPath()
{
    const std::string inherited = environment("PYTHONPATH").string();
    // An empty entry would be the current folder.
    return pythonFolder().string() + (inherited.empty() ? "" : ":" + inherited);
}

fs::path cacheFolder()
{
    if (auto given = environment("RESTIRPG_CACHE_DIR"); !given.empty())
        return given;
    if (const auto xdg = environment("XDG_CACHE_HOME"); !xdg.empty())
        return xdg / "restirpg";
    const auto home = environment("HOME");
    return home.empty() ? home : home / ".cache/restirpg";
}

void requireExtension(const fs::path& file, const std::string& extension)
{
    if (file.extension() != extension)
        failAs<WrongValue>("{}: the name must end in {}", file.string(), extension);
}

void refuseInput(const fs::path& output, const std::vector<fs::path>& inputs)
{
    std::error_code missing;  // what is not there is not the same
    for (const auto& input : inputs)
        if (fs::equivalent(output, input, missing))
            fail("{}: cannot write: it is the file {}, which was read; choose another name", output.string(),
                 input.string());
}

}  // namespace restirpg
