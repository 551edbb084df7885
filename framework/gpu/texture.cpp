#include "gpu/texture.h"

#include "core/error.h"

namespace restirpg {
namespace {

VkImageMemoryBarrier layoutChange(VkImage image, VkImageLayout from, VkImageLayout to)
{
    VkImageMemoryBarrier barrier{VK_STRUCTURE_TYPE_IMAGE_MEMORY_BARRIER};
    barrier.srcAccessMask = VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.dstAccessMask = VK_ACCESS_MEMORY_READ_BIT | VK_ACCESS_MEMORY_WRITE_BIT;
    barrier.oldLayout = from;
    barrier.newLayout = to;
    barrier.srcQueueFamilyIndex = barrier.dstQueueFamilyIndex = VK_QUEUE_FAMILY_IGNORED;
    barrier.image = image;
    barrier.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    return barrier;
}

void changeLayout(VkCommandBuffer commands, VkImage image, VkImageLayout from, VkImageLayout to)
{
    const auto barrier = layoutChange(image, from, to);
    vkCmdPipelineBarrier(commands, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, VK_PIPELINE_STAGE_ALL_COMMANDS_BIT, 0, 0, nullptr, 0,
                         nullptr, 1, &barrier);
}

VkFormat formatOf(const TextureSource& source)
{
    if (!source.floats.empty())
        return VK_FORMAT_R32G32B32A32_SFLOAT;
    return source.srgb ? VK_FORMAT_R8G8B8A8_SRGB : VK_FORMAT_R8G8B8A8_UNORM;
}

}  // namespace

BindingSet::BindingSet(Device& device, std::span<const TextureSource> sources) : device_(device)
{
    if (sources.size() > device.maxTextures())
        fail("the scene has {} textures; device '{}' binds {}", sources.size(), device.description().name, device.maxTextures());
    for (const auto& source : sources)
        textures_.push_back(createTexture(source));

    const uint32_t count = std::max<uint32_t>(uint32_t(textures_.size()), 1);
    std::vector<VkDescriptorPoolSize> sizes = {{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, count}};
    if (device.backend() == Backend::rayQuery)
        sizes.push_back({VK_DESCRIPTOR_TYPE_ACCELERATION_STRUCTURE_KHR, 1});
    VkDescriptorPoolCreateInfo pool{VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO};
    pool.maxSets = 1;
    pool.poolSizeCount = uint32_t(sizes.size());
    pool.pPoolSizes = sizes.data();
    check(vkCreateDescriptorPool(device.handle(), &pool, nullptr, &pool_), "vkCreateDescriptorPool");

    VkDescriptorSetVariableDescriptorCountAllocateInfo variable{
        VK_STRUCTURE_TYPE_DESCRIPTOR_SET_VARIABLE_DESCRIPTOR_COUNT_ALLOCATE_INFO};
    variable.descriptorSetCount = 1;
    variable.pDescriptorCounts = &count;
    const VkDescriptorSetLayout layout = device.setLayout();
    VkDescriptorSetAllocateInfo allocate{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO, &variable};
    allocate.descriptorPool = pool_;
    allocate.descriptorSetCount = 1;
    allocate.pSetLayouts = &layout;
    check(vkAllocateDescriptorSets(device.handle(), &allocate, &set_), "vkAllocateDescriptorSets");
    writeTextures();
}

BindingSet::~BindingSet()
{
    for (const auto& texture : textures_) {
        vkDestroySampler(device_.handle(), texture.sampler, nullptr);
        vkDestroyImageView(device_.handle(), texture.view, nullptr);
        vkDestroyImage(device_.handle(), texture.image, nullptr);
        device_.freeMemory(texture.memory, texture.memoryBytes);
    }
    vkDestroyDescriptorPool(device_.handle(), pool_, nullptr);
}

BindingSet::Texture BindingSet::createTexture(const TextureSource& source)
{
    Texture texture;
    VkImageCreateInfo info{VK_STRUCTURE_TYPE_IMAGE_CREATE_INFO};
    info.imageType = VK_IMAGE_TYPE_2D;
    info.format = formatOf(source);
    info.extent = {source.width, source.height, 1};
    info.mipLevels = 1;
    info.arrayLayers = 1;
    info.samples = VK_SAMPLE_COUNT_1_BIT;
    info.usage = VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT;
    check(vkCreateImage(device_.handle(), &info, nullptr, &texture.image), "vkCreateImage");
    VkMemoryRequirements requirements;
    vkGetImageMemoryRequirements(device_.handle(), texture.image, &requirements);
    texture.memory = device_.allocateMemory(requirements, VK_MEMORY_PROPERTY_DEVICE_LOCAL_BIT, false);
    texture.memoryBytes = requirements.size;
    check(vkBindImageMemory(device_.handle(), texture.image, texture.memory, 0), "vkBindImageMemory");
    device_.setName(uint64_t(texture.image), VK_OBJECT_TYPE_IMAGE, source.name);

    const Buffer pixels = source.floats.empty() ? device_.createBuffer(source.bytes, "texels")
                                                : device_.createBuffer(source.floats, "texels");
    device_.submit([&](VkCommandBuffer commands) {
        changeLayout(commands, texture.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL);
        VkBufferImageCopy copy{};
        copy.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
        copy.imageExtent = info.extent;
        vkCmdCopyBufferToImage(commands, pixels.handle(), texture.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, 1, &copy);
        changeLayout(commands, texture.image, VK_IMAGE_LAYOUT_TRANSFER_DST_OPTIMAL, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL);
    });

    VkImageViewCreateInfo view{VK_STRUCTURE_TYPE_IMAGE_VIEW_CREATE_INFO};
    view.image = texture.image;
    view.viewType = VK_IMAGE_VIEW_TYPE_2D;
    view.format = info.format;
    view.subresourceRange = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
    check(vkCreateImageView(device_.handle(), &view, nullptr, &texture.view), "vkCreateImageView");
    VkSamplerCreateInfo sampler{VK_STRUCTURE_TYPE_SAMPLER_CREATE_INFO};
    sampler.magFilter = sampler.minFilter = source.filter;
    sampler.addressModeU = source.wrapU;
    sampler.addressModeV = source.wrapV;
    check(vkCreateSampler(device_.handle(), &sampler, nullptr, &texture.sampler), "vkCreateSampler");
    return texture;
}

void BindingSet::writeTextures()
{
    std::vector<VkDescriptorImageInfo> images;
    for (const auto& texture : textures_)
        images.push_back({texture.sampler, texture.view, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL});
    if (images.empty())
        return;
    VkWriteDescriptorSet write{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET};
    write.dstSet = set_;
    write.dstBinding = 1;
    write.descriptorCount = uint32_t(images.size());
    write.descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
    write.pImageInfo = images.data();
    vkUpdateDescriptorSets(device_.handle(), 1, &write, 0, nullptr);
}

void BindingSet::setAccelerationStructure(VkAccelerationStructureKHR structure)
{
    VkWriteDescriptorSetAccelerationStructureKHR accel{VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET_ACCELERATION_STRUCTURE_KHR};
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
    vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, device_.pipelineLayout(), 0, 1, &set_, 0, nullptr);
}

}  // namespace restirpg
