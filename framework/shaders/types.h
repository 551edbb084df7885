// The basic types of a struct that C++ and GLSL share. In GLSL the file only sets the extensions that sharing needs;
// in C++ it makes GLSL's spelling valid. Shared structs use scalar block layout: no padding, no alignment above 4
// (8 for an Address), so members are ordered with the addresses first.
#ifndef RESTIRPG_TYPES_H
#define RESTIRPG_TYPES_H

#ifdef __cplusplus
#include <cstdint>
#include <glm/glm.hpp>
#define RESTIRPG_SHARED namespace restirpg {
#define RESTIRPG_SHARED_END }
namespace restirpg {
using uint = uint32_t;
using glm::ivec2;
using glm::ivec3;
using glm::mat2;
using glm::mat4x3;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;
/// A device address (VkDeviceAddress). 0 means "not there".
using Address = uint64_t;
}  // namespace restirpg
#else
#define RESTIRPG_SHARED
#define RESTIRPG_SHARED_END
#define Address uint64_t
#endif

#endif
