// The one descriptor set that every kernel sees. Everything else is read through device addresses.
#pragma once

#include "gpu/device.h"

namespace restirpg {

/// For ray query the acceleration structure (binding 0); the software back end needs no descriptors.
class BindingSet {
public:
    explicit BindingSet(Device& device);
    ~BindingSet();
    BindingSet(const BindingSet&) = delete;
    BindingSet& operator=(const BindingSet&) = delete;

    void setAccelerationStructure(VkAccelerationStructureKHR structure);
    void bind(VkCommandBuffer commands) const;

private:
    Device& device_;
    VkDescriptorPool pool_ = VK_NULL_HANDLE;
    VkDescriptorSet set_ = VK_NULL_HANDLE;
};

}  // namespace restirpg
