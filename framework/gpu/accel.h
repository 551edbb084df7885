// Vulkan acceleration structures for the ray query back end.
#pragma once

#include "gpu/device.h"
#include "shaders/scene/scene_types.h"

#include <memory>
#include <span>
#include <vector>

namespace restirpg {

/// A range of the scene's geometry that becomes one bottom-level structure.
struct AccelerationMesh {
    uint64_t vertices;  ///< device address of the first one
    uint64_t indices;  ///< device address of the first triangle (uvec3)
    uint32_t vertexCount;
    uint32_t triangleCount;
    bool opaque;  ///< no alpha mask: never reports candidates
};

class AccelerationStructures {
public:
    AccelerationStructures(Device& device, std::span<const AccelerationMesh> meshes);
    ~AccelerationStructures();
    AccelerationStructures(const AccelerationStructures&) = delete;
    AccelerationStructures& operator=(const AccelerationStructures&) = delete;

    /// (Re)build the top level over the instances; the custom index is the instance's place in the span.
    void buildTopLevel(std::span<const Instance> instances, std::span<const uint32_t> meshOfInstance);
    VkAccelerationStructureKHR topLevel() const { return top_.handle; }

private:
    explicit AccelerationStructures(Device& device) : device_(device) {}
    struct Structure {
        VkAccelerationStructureKHR handle = VK_NULL_HANDLE;
        Buffer storage;
        uint64_t address = 0;
    };
    Structure build(VkAccelerationStructureTypeKHR type, const VkAccelerationStructureGeometryKHR& geometry,
                    uint32_t primitives);
    void destroy(Structure& structure);

    Device& device_;
    std::vector<Structure> meshes_;
    Structure top_;
    Buffer instances_;
};

}  // namespace restirpg
