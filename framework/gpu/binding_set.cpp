#include "gpu/binding_set.h"

namespace restirpg {

BindingSet::BindingSet(Device& device) : device_(device)
{
    if (device.backend() != Backend::rayQuery)
        return;
    const VkDescriptorPoolSize size{VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1};
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = 1;
    pool.pPoolSizes = &size;
    check(vkCreateDescriptorPool(device.handle(), &pool, nullptr, &pool_), "vkCreateDescriptorPool");
    const VkDescriptorSetLayout layout = device.setLayout();
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    check(vkAllocateDescriptorSets(device.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
}

BindingSet::~BindingSet()
{
    vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
}

void BindingSet::setAccelerationStructure(VkAccelerationStructureKHR structure)
{
    VkWriteDescriptorSetAccelerationStructureKHR accel{
        VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
    accel.accelerationStructureCount = 1;
    accel.pAccelerationStructures = &structure;
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET, &accel};
    write.dstSet = set_;
    write.dstBinding = 0;
    write.descriptorCount = 1;
    write.descriptorType = VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR;
    vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

void BindingSet::bind(VkCommandBuffer commands) const
{
    if (set_)
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.pipelineLayout(), 0, 1, &set_, 0,
                                nullptr);
}

}  // namespace restirpg
