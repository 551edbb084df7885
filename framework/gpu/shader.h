// GLSL to SPIR-V, in process, with a cache on disk.
#pragma once

#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace restirpg {

/// Preprocessor definitions of a kernel: name to value.
using Defines = std::map<std::string, std::string>;

/// Names that #include finds elsewhere: "guide_module.glsl" to the file a graph chose.
using Includes = std::map<std::string, std::filesystem::path>;

using Spirv = std::vector<uint32_t>;

/// Compile a compute shader. `#include "x"` looks in `includes`, beside the including file, in shaderFolder() and in
/// its parent. Errors are one Error holding glslang's messages (FILE:LINE: ...). The result is kept in
/// cacheFolder()/spirv under the hash of the defines and of all files that may be included, so an edit of any of them
/// is seen. May be called by several threads at once.
Spirv compileShader(const std::filesystem::path& file, const Defines& defines = {}, const Includes& includes = {});

/// Local size of a compute shader, from its LocalSize execution mode.
struct LocalSize {
    uint32_t x = 1, y = 1, z = 1;
};
LocalSize localSize(const Spirv& spirv);

}  // namespace restirpg
