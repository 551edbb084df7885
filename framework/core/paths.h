// Where the program finds its own files, in a build tree and when installed.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace restirpg {

/// The folder of librestirpg.so (or of the test program that contains it).
std::filesystem::path libraryFolder();

/// The GLSL library `framework/shaders`: RESTIRPG_SHADERS if set, the installed share/restirpg/shaders beside the
/// library, else the source tree.
std::filesystem::path shaderFolder();

/// The pure-Python package's parent folder: what PYTHONPATH needs.
std::filesystem::path pythonFolder();

/// The OpenColorIO config of the display transforms.
std::filesystem::path displayConfig();

/// Where a plugin keeps its kernels: the folder of the library's name beside the library (that is how `cmake --install`
/// lays them out) if there is one, else `source`, as seen from the library's folder. `inside` is the address of
/// anything in the plugin. Passes call passFile of graph/pass.h.
std::filesystem::path pluginFolder(const void* inside, const std::filesystem::path& source);

/// The interpreter that evaluates graph files: RESTIRPG_PYTHON if set, else the one that this process runs in, else the
/// one found at configure time.
std::filesystem::path pythonInterpreter();

/// How that interpreter is started with a module of the package: before the module's own arguments. The current folder,
/// which may be anybody's, is not on its path: Python would put it before the standard library.
std::vector<std::string> pythonModule(const std::string& module);

/// What PYTHONPATH has to be then: the package's folder and what is inherited.
std::string pythonPath();

/// Called by the Python module: this process runs in `program`.
void setPythonInterpreter(const std::filesystem::path& program);

/// Per-user cache: RESTIRPG_CACHE_DIR, else $XDG_CACHE_HOME/restirpg, else ~/.cache/restirpg, else (no HOME) empty.
std::filesystem::path cacheFolder();

/// Throws Error when the name of `file`, which is to be written, ends in anything but `extension` (".exr").
void requireExtension(const std::filesystem::path& file, const std::string& extension);

/// Throws Error when `output`, which is to be written, is one of the files that were read, by whatever path or link.
void refuseInput(const std::filesystem::path& output, const std::vector<std::filesystem::path>& inputs);

}  // namespace restirpg
