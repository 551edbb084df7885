// Inside the glTF reader: the checked file, and the steps that turn it into a Scene. Not for other folders.
#pragma once

#include "core/error.h"
#include "core/hash.h"
#include "core/log.h"
#include "scene/scene.h"

#include <nlohmann/json_fwd.hpp>
#include <tiny_gltf.h>

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <span>
#include <string_view>

namespace restirpg::gltf {

/// What a scene file's URIs stand for. A file that is not below the scene's folder, symbolic links followed, is refused
/// unless the user allows it: a scene from elsewhere must not read what its author could not.
class Resources {
public:
    Resources(const std::filesystem::path& scene, bool allowOutside);

    static bool isData(const std::string& uri);

    /// The bytes of a data URI. `place` names it in errors ("buffers[0]").
    std::vector<uint8_t> readData(const std::string& uri, const std::string& place) const;

    /// The file that a URI or a plain path names: it may be missing, but is no folder, device or pipe.
    std::filesystem::path resolveUri(const std::string& uri, const std::string& place) const;
    std::filesystem::path resolve(std::string_view name, const std::string& place) const;
    /// As resolveUri, of a file that must be there: throws MissingFile where it is not.
    std::filesystem::path resolveExisting(const std::string& uri, const std::string& place) const;

private:
    std::filesystem::path scene_, folder_;
    bool allowOutside_;
};

/// A glTF file after the structural check: every index of `model` is in range and every buffer view lies in its buffer.
struct File {
    std::filesystem::path path;
    Resources resources;
    tinygltf::Model model{};
    std::vector<std::filesystem::path> external{};  ///< files it names, which were read
    uint64_t hash = 0;  ///< FNV-1a of the file and of the external files it names

    std::string name() const { return path.string(); }
};

/// Read and check the container, the JSON and the buffers. Images stay encoded (tinygltf::Image::image) until a
/// texture needs them. Throws Error for everything that is damaged, hostile or needs an extension that this reader
/// lacks.
File readFile(const std::filesystem::path& path, bool allowOutside);

/// All bytes of a file.
std::vector<uint8_t> readBytes(const std::filesystem::path& path);

/// Write each number as the type that its readers ask for: 4, 4.0 and 4e0 become an integer [glTF 2.0, 2.7]. What is
/// larger than any index or offset becomes a double. In extensions and extras, where tinygltf casts integers to int, so
/// does what is larger than an int.
void unifyNumbers(nlohmann::json& root);

/// Check the JSON, its numbers unified, against the parts of the glTF schema that the reader relies on: types, array
/// lengths, index ranges, buffer view ranges. tinygltf ignores optional members of the wrong type and trusts indices;
/// after this check neither matters. Throws Error naming the JSON path.
void checkStructure(const std::string& file, const nlohmann::json& root);

/// "mesh 3 'Floor'", or "mesh 3" where it has no name.
std::string label(std::string_view kind, size_t index, const std::string& name);

/// The elements of an accessor as floats, element after element, no more than the first `most`; integers are normalised
/// where the accessor says so. `place` names it in errors ("mesh 3 'Floor' POSITION"); the accessor's type must be one
/// of `types` (TINYGLTF_TYPE_*). Throws Error when it leaves its buffer view, has another type, or when what is read
/// holds a NaN or an infinity.
std::vector<float> readFloats(const File& file, int accessor, const std::string& place,
                              std::initializer_list<int> types, size_t most = SIZE_MAX);

/// Throws Error when an accessor leaves its buffer view; what it counts is then bounded.
void checkAccessor(const File& file, int accessor, const std::string& place);

/// All elements of a scalar accessor of unsigned integers.
std::vector<uint32_t> readIndices(const File& file, int accessor, const std::string& place);

/// Decode image `index` (PNG or JPEG) into `texture`: 8 bit as stored, 16 bit as linear floats. `texture.srgb` says
/// how to read it. Throws Error naming the image when it cannot be decoded or is larger than 16384 a side.
void decodeImage(const File& file, int index, Texture& texture);

/// Called with what a header claims, before memory is taken for it; throws Error where that is too much.
using CheckSize = std::function<void(uint32_t width, uint32_t height, bool sixteenBits)>;

/// A decoded JPEG, or why there is none.
struct JpegImage {
    bool valid = false;
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> rgba;
    std::string message;  ///< the error, or the first warning about damaged data; empty: none
};

/// Is a JPEG of so many scans a bomb rather than a picture?
bool hasTooManyScans(uint64_t scans, uint32_t width, uint32_t height);

JpegImage decodeJpeg(std::span<const uint8_t> encoded, const CheckSize& check);

/// A decoded PNG, or why there is none.
struct PngImage {
    bool valid = false;
    uint32_t width = 0;
    uint32_t height = 0;
    bool sixteenBits = false;
    std::vector<uint8_t> rgba;  ///< with 16 bits, two bytes a component in the machine's order
    std::string message;  ///< the error; empty: none
};

PngImage decodePng(std::span<const uint8_t> encoded, const CheckSize& check);

/// Fill scene.materials (one a glTF material, then the default material) and scene.textures.
void readMaterials(const File& file, Scene& scene);

/// Fill nodes, cameras, lights and animation of the default scene.
void readNodes(const File& file, Scene& scene);

/// Fill the geometry, meshes and instances that the nodes show. Needs the materials and the nodes.
void readInstances(const File& file, Scene& scene);

/// A node of the file as a node of the scene.
Node makeNode(const File& file, size_t index, int parent);

/// Say, once a file, that what deforms meshes stands still.
void warnOfDeformation(const File& file);

/// Tangents for the vertices of triangles that have normals and texture coordinates but no TANGENT. `uv` are the
/// normal map's (transformed) coordinates; all arrays are per vertex; every vertex must be used by triangles of one
/// UV orientation only. A vertex whose triangles have no UV area gets a zero tangent.
void generateTangents(const std::vector<glm::uvec3>& triangles, const std::vector<glm::vec3>& positions,
                      const std::vector<glm::vec2>& uv, std::vector<VertexAttributes>& attributes);

/// Whether a triangle's texture coordinates are mirrored against its winding: the sign that a shared vertex must not
/// mix.
bool mirroredUv(const std::array<glm::vec2, 3>& uv);

/// A member of an extension's JSON, nullptr where it is missing.
const tinygltf::Value* member(const tinygltf::Value& object, const char* name);

/// An extension of a glTF object, nullptr where it is missing.
const tinygltf::Value* extension(const tinygltf::ExtensionMap& map, const char* name);

/// A number of an extension's JSON, `otherwise` where it is missing.
float number(const tinygltf::Value& object, const char* name, double otherwise);

/// Three numbers of an extension's JSON, `otherwise` where they are missing.
glm::vec3 color(const tinygltf::Value& object, const char* name, glm::vec3 otherwise);

}  // namespace restirpg::gltf
