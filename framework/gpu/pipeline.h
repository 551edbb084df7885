// Kernels as the driver holds them, each made once in a process and shared by all of the same SPIR-V.
#pragma once

#include "gpu/shader.h"
#include "gpu/shader_object.h"

#include <volk.h>

#include <future>
#include <memory>
#include <mutex>

namespace restirpg {

class LogicalDevice;

/// A compute pipeline, or a shader object where the device has those (LogicalDevice::shaderObjects).
class Pipeline {
public:
    /// `device` must outlive it. `name` is for debuggers.
    Pipeline(const LogicalDevice& device, const Spirv& spirv, const std::string& name);
    ~Pipeline();
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;

    void bind(VkCommandBuffer commands) const;
    const LocalSize& groupSize() const { return groupSize_; }

private:
    void makeShader(const Spirv& spirv);
    void makePipeline(const Spirv& spirv, const std::string& name);

    const LogicalDevice& device_;
    // One of the two.
    VkShaderEXT shader_ = VK_NULL_HANDLE;
    VkPipeline pipeline_ = VK_NULL_HANDLE;
    LocalSize groupSize_;
};

/// A device's pipelines. get may be called by several threads at once: they make different pipelines side by side.
class PipelineCache {
public:
    explicit PipelineCache(const LogicalDevice& device) : device_(device) {}

    std::shared_ptr<const Pipeline> get(const Spirv& spirv, const std::string& name);
    void clear() { pipelines_.clear(); }

private:
    using Made = std::shared_ptr<const Pipeline>;

    void dropUnused();

    const LogicalDevice& device_;
    std::mutex mutex_;
    std::map<Spirv, std::shared_future<Made>> pipelines_;
};

}  // namespace restirpg
