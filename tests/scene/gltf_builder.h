// Small glTF files made in the test, so that no binary asset is needed and every byte is known.
#pragma once

#include "core/error.h"
#include "scene/scene.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace restirpg {

constexpr int BYTE = 5120, UNSIGNED_BYTE = 5121, SHORT = 5122, UNSIGNED_SHORT = 5123, UNSIGNED_INT = 5125, FLOAT = 5126;

/// Collects JSON and binary data; `json` may be edited freely before `write`.
class GltfBuilder {
public:
    GltfBuilder();

    /// Append bytes as a buffer view (aligned to 4); `stride` 0: none.
    int addView(const void* bytes, size_t size, size_t stride = 0);

    /// Append an accessor over tightly packed values.
    template <typename T>
    int addAccessor(const std::vector<T>& values, int componentType, const std::string& type, bool normalized = false)
    {
        const size_t components = type == "SCALAR" ? 1 : size_t(type.back() - '0');
        nlohmann::json accessor = {{"bufferView", addView(values.data(), values.size() * sizeof(T))},
                                   {"componentType", componentType},
                                   {"count", values.size() / components},
                                   {"type", type}};
        if (normalized)
            accessor["normalized"] = true;
        return addAccessorJson(accessor);
    }

    int addAccessorJson(const nlohmann::json& accessor) { return append(json["accessors"], accessor); }
    int addMesh(const nlohmann::json& primitives, const std::string& name = "");
    int addMaterial(const nlohmann::json& material) { return append(json["materials"], material); }

    /// Append a node; a root of the scene unless it is somebody's child.
    int addNode(const nlohmann::json& node, bool root = true);

    /// Append an image (encoded bytes) with a texture on it.
    int addTexture(const std::vector<uint8_t>& encoded, const nlohmann::json& sampler = nullptr);

    /// Write as .glb or .gltf (buffer as a data URI), by the extension of `file`; returns `file`.
    std::filesystem::path write(const std::filesystem::path& file) const;

    nlohmann::json json;

private:
    static int append(nlohmann::json& array, const nlohmann::json& element);

    std::vector<uint8_t> binary_;
};

/// A unit square in the plane z = 0 facing +z with normals and upright texture coordinates, as a primitive.
nlohmann::json addSquare(GltfBuilder& builder);

/// A builder with one such square on one node.
GltfBuilder squareScene();

/// A folder of this process for files; removed at exit.
std::filesystem::path scratch();

/// Load what the builder holds, through a .glb.
Scene load(const GltfBuilder& builder);

/// A triangle's corners from its earliest vertex on, in the file's order: the reader turns them.
glm::uvec3 fromEarliestVertex(glm::uvec3 triangle);

/// The message of the Error that loading raises; fails the test when it raises none or more than one line.
std::string errorOf(const GltfBuilder& builder);

/// The message of the Error that `run` raises; same rules.
std::string errorOf(const std::function<void()>& run);

/// Whether one of the warnings said so far contains `part`.
bool wasWarned(const std::string& part);

/// Expect a distance between the points of less than `tolerance`.
void expectNear(glm::vec3 a, glm::vec3 b, float tolerance = 1e-6f);

/// Write bytes to a file.
void writeBytes(const std::filesystem::path& file, const std::vector<uint8_t>& bytes);

std::vector<uint8_t> readBytes(const std::filesystem::path& file);

/// A PNG (or JPEG) of RGBA bytes.
std::vector<uint8_t> encodePng(int width, int height, const std::vector<uint8_t>& rgba);
std::vector<uint8_t> encodeJpeg(int width, int height, const std::vector<uint8_t>& rgba);

std::string encodeBase64(const std::vector<uint8_t>& bytes);

/// Files that between them use every feature of the reader: for mutations.
GltfBuilder geometryScene();
GltfBuilder texturedScene();
GltfBuilder animatedScene();

}  // namespace restirpg
