// Compute pipelines, each made once in a process and shared by all kernels of the same SPIR-V.
#pragma once

#include "gpu/shader.h"

#include <volk.h>

#include <future>
#include <memory>
#include <mutex>

namespace restirpg {

class LogicalDevice;

class Pipeline {
public:
    /// `device` must outlive it.
    Pipeline(const LogicalDevice& device, const Spirv& spirv, const std::string& name);
    ~Pipeline();
    Pipeline(const Pipeline&) = delete;
    Pipeline& operator=(const Pipeline&) = delete;

    VkPipeline handle() const { return handle_; }
    const LocalSize& groupSize() const { return groupSize_; }

private:
    VkDevice device_;
    VkPipeline handle_ = VK_NULL_HANDLE;
    LocalSize groupSize_;
};

/// A device's pipelines. get may be called by several threads at once: they make different pipelines side by side.
class PipelineCache {
public:
    explicit PipelineCache(const LogicalDevice& device) : device_(device) {}

    /// The pipeline of this SPIR-V; `name` is for debuggers.
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
