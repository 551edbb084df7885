#include "gpu/accel.h"

namespace restirpg {
namespace {

VkAccelerationStructureGeometryKHR triangleGeometry(const AccelerationMesh& mesh)
{
    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_TRIANGLES_KHR;
    geometry.flags = mesh.opaque ? VK_GEOMETRY_OPAQUE_BIT_KHR : 0;
    auto& triangles = geometry.geometry.triangles;
    triangles.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_TRIANGLES_DATA_KHR;
    triangles.vertexFormat = VK_FORMAT_R32G32B32_SFLOAT;
    triangles.vertexData.deviceAddress = mesh.vertices;
    triangles.vertexStride = sizeof(MeshVertex);
    triangles.maxVertex = mesh.vertexCount - 1;
    triangles.indexType = VK_INDEX_TYPE_UINT32;
    triangles.indexData.deviceAddress = mesh.indices;
    return geometry;
}

VkTransformMatrixKHR toRows(const glm::mat4x3& m)
{
    VkTransformMatrixKHR rows;
    for (int row = 0; row < 3; ++row)
        for (int column = 0; column < 4; ++column)
            rows.matrix[row][column] = m[column][row];
    return rows;
}

}  // namespace

AccelerationStructures::AccelerationStructures(Device& device, std::span<const AccelerationMesh> meshes)
    : AccelerationStructures(device)
{
    for (const auto& mesh : meshes)
        meshes_.push_back(mesh.triangleCount == 0 ? Structure{}
                                                  : build(VK_ACCELERATION_STRUCTURE_TYPE_BOTTOM_LEVEL_KHR,
                                                          triangleGeometry(mesh), mesh.triangleCount));
}

AccelerationStructures::~AccelerationStructures()
{
    destroy(top_);
    for (auto& structure : meshes_)
        destroy(structure);
}

void AccelerationStructures::destroy(Structure& structure)
{
    if (structure.handle)
        vkDestroyAccelerationStructureKHR(device_.handle(), structure.handle, nullptr);
    structure = {};
}

AccelerationStructures::Structure AccelerationStructures::build(VkAccelerationStructureTypeKHR type,
                                                                const VkAccelerationStructureGeometryKHR& geometry,
                                                                uint32_t primitives)
{
    VkAccelerationStructureBuildGeometryInfoKHR info{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_GEOMETRY_INFO_KHR};
    info.type = type;
    info.flags = VK_BUILD_ACCELERATION_STRUCTURE_PREFER_FAST_TRACE_BIT_KHR;
    info.mode = VK_BUILD_ACCELERATION_STRUCTURE_MODE_BUILD_KHR;
    info.geometryCount = 1;
    info.pGeometries = &geometry;
    VkAccelerationStructureBuildSizesInfoKHR sizes{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_BUILD_SIZES_INFO_KHR};
    vkGetAccelerationStructureBuildSizesKHR(device_.handle(), VK_ACCELERATION_STRUCTURE_BUILD_TYPE_DEVICE_KHR, &info,
                                            &primitives, &sizes);

    Structure structure;
    structure.storage = device_.createBuffer(sizes.accelerationStructureSize, "acceleration structure");
    VkAccelerationStructureCreateInfoKHR create{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_CREATE_INFO_KHR};
    create.buffer = structure.storage.handle();
    create.size = sizes.accelerationStructureSize;
    create.type = type;
    check(vkCreateAccelerationStructureKHR(device_.handle(), &create, nullptr, &structure.handle),
          "vkCreateAccelerationStructureKHR");

    // Scratch addresses must be aligned; 256 is the largest alignment a device may ask for.
    constexpr uint64_t ALIGNMENT = 256;
    const Buffer scratch = device_.createBuffer(sizes.buildScratchSize + ALIGNMENT, "acceleration structure scratch");
    info.dstAccelerationStructure = structure.handle;
    info.scratchData.deviceAddress = (scratch.address() + ALIGNMENT - 1) / ALIGNMENT * ALIGNMENT;
    const VkAccelerationStructureBuildRangeInfoKHR range{primitives, 0, 0, 0};
    const auto* ranges = &range;
    device_.submit([&](VkCommandBuffer commands) { vkCmdBuildAccelerationStructuresKHR(commands, 1, &info, &ranges); });

    VkAccelerationStructureDeviceAddressInfoKHR address{
        VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_DEVICE_ADDRESS_INFO_KHR};
    address.accelerationStructure = structure.handle;
    structure.address = vkGetAccelerationStructureDeviceAddressKHR(device_.handle(), &address);
    return structure;
}

void AccelerationStructures::buildTopLevel(std::span<const Instance> instances,
                                           std::span<const uint32_t> meshOfInstance)
{
    std::vector<VkAccelerationStructureInstanceKHR> records;
    for (uint32_t i = 0; i < instances.size(); ++i) {
        const uint32_t mesh = meshOfInstance[i];
        if (!meshes_[mesh].handle)
            continue;
        VkAccelerationStructureInstanceKHR record{};
        record.transform = toRows(instances[i].objectToWorld);
        record.instanceCustomIndex = i;
        record.mask = 0xff;
        record.flags = VK_GEOMETRY_INSTANCE_TRIANGLE_FACING_CULL_DISABLE_BIT_KHR;
        record.accelerationStructureReference = meshes_[mesh].address;
        records.push_back(record);
    }
    const uint64_t bytes = std::max<uint64_t>(records.size() * sizeof(records[0]), 16);
    if (instances_.bytes() < bytes)
        instances_ = device_.createBuffer(bytes, "instances");
    device_.upload(instances_, records.data(), records.size() * sizeof(records[0]));

    VkAccelerationStructureGeometryKHR geometry{VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_KHR};
    geometry.geometryType = VK_GEOMETRY_TYPE_INSTANCES_KHR;
    geometry.geometry.instances.sType = VK_STRUCTURE_TYPE_ACCELERATION_STRUCTURE_GEOMETRY_INSTANCES_DATA_KHR;
    geometry.geometry.instances.data.deviceAddress = instances_.address();
    destroy(top_);
    top_ = build(VK_ACCELERATION_STRUCTURE_TYPE_TOP_LEVEL_KHR, geometry, uint32_t(records.size()));
}

}  // namespace restirpg
