#include "render/executor.h"

#include <algorithm>

namespace restirpg {

Executor::Executor(Device& device, std::unique_ptr<Graph> graph, uint32_t width, uint32_t height,
                   const CompileProgress& progress)
    : device_(device), graph_(std::move(graph)), width_(width), height_(height)
{
    for (const auto& plan : graph_->resources()) {
        auto& resource = resources_.emplace_back();
        resource.plan = plan;
        allocate(resource);
    }
    constants_ = device_.createBuffer(sizeof(FrameConstants), "frame constants");
    for (const auto& edge : graph_->edges())
        graph_->passes()[edge.target].interface.inputs()[edge.input].target->module =
            graph_->passes()[edge.source].interface.outputs()[edge.output].type.module;
    connect();
    for (uint32_t pass : graph_->order())
        graph_->passes()[pass].pass->build(device_);
    device_.finishKernels(progress);
    // Last, so that a pass that fails to build leaves nothing behind.
    VkQueryPoolCreateInfo info{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
    info.queryType = VK_QUERY_TYPE_TIMESTAMP;
    info.queryCount = uint32_t(2 * graph_->order().size());
    check(vkCreateQueryPool(device_.handle(), &info, nullptr, &queries_), "vkCreateQueryPool");
}

Executor::~Executor()
{
    vkDestroyQueryPool(device_.handle(), queries_, nullptr);
}

void Executor::allocate(Resource& resource)
{
    const auto& pass = graph_->passes()[resource.plan.pass];
    const auto& port = pass.interface.outputs()[resource.plan.output];
    const std::string name = pass.name + "." + port.name;
    for (int copy = 0; copy < (resource.plan.delayed ? 2 : 1); ++copy)
        resource.copies[copy] = device_.createBuffer(port.type.bytes(width_, height_), name);
}

void Executor::cut()
{
    frame_ = 0;
    times_.clear();
    totalTimes_.clear();
    // Zeroed, so that a pass that does not ask whether its history is empty still reads nothing of the past.
    for (auto& resource : resources_)
        if (resource.plan.delayed)
            device_.submit([&](VkCommandBuffer commands) {
                vkCmdFillBuffer(commands, resource.copies[resource.current].handle(), 0, VK_WHOLE_SIZE, 0);
            });
}

void Executor::rebuild(GraphPass& pass)
{
    for (auto& resource : resources_)
        if (&graph_->passes()[resource.plan.pass] == &pass)
            allocate(resource);
    if (pass.live) {
        pass.pass->build(device_);
        device_.finishKernels();
    }
    cut();
}

/// Point every port at this frame's buffers.
void Executor::connect()
{
    auto& passes = graph_->passes();
    const auto resourceOf = [&](uint32_t pass, uint32_t output) {
        return std::find_if(resources_.begin(), resources_.end(), [&](const Resource& resource) {
            return resource.plan.pass == pass && resource.plan.output == output;
        });
    };
    for (auto& resource : resources_) {
        if (resource.plan.delayed)
            resource.current ^= 1;
        auto& port = passes[resource.plan.pass].interface.outputs()[resource.plan.output];
        port.target->resource = &resource.copies[resource.current];
    }
    for (const auto& edge : graph_->edges()) {
        if (!passes[edge.target].live)
            continue;
        const auto& resource = *resourceOf(edge.source, edge.output);
        auto& input = *passes[edge.target].interface.inputs()[edge.input].target;
        input.resource = &resource.copies[edge.delayed ? resource.current ^ 1 : resource.current];
        input.empty = edge.delayed && frame_ == 0;
    }
}

void Executor::run(FrameConstants constants, const BindingSet& bindings)
{
    constants.frame = frame_;
    constants.reset = frame_ == 0;
    connect();
    device_.submit([&](VkCommandBuffer commands) {
        vkCmdUpdateBuffer(commands, constants_.handle(), 0, sizeof constants, &constants);
        record(commands, bindings);
    });
    readTimes();
    ++frame_;
}

void Executor::record(VkCommandBuffer commands, const BindingSet& bindings)
{
    const auto& order = graph_->order();
    vkCmdResetQueryPool(commands, queries_, 0, uint32_t(2 * order.size()));
    bindings.bind(commands);
    Frame frame(device_, commands, constants_.address(), width_, height_, frame_, frame_ == 0);
    for (uint32_t i = 0; i < order.size(); ++i) {
        auto& pass = graph_->passes()[order[i]];
        device_.beginLabel(commands, pass.name + " (" + pass.type + ")");
        // Both stamps wait for all earlier work, so that the passes' times are disjoint and add up to the frame's.
        vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, 2 * i);
        pass.pass->record(frame);
        vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, 2 * i + 1);
        device_.endLabel(commands);
    }
}

void Executor::readTimes()
{
    const auto& order = graph_->order();
    std::vector<uint64_t> stamps(2 * order.size());
    check(vkGetQueryPoolResults(device_.handle(), queries_, 0, uint32_t(stamps.size()), stamps.size() * sizeof(uint64_t),
                                stamps.data(), sizeof(uint64_t), VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
          "vkGetQueryPoolResults");
    for (size_t i = 0; i < order.size(); ++i) {
        const std::string& name = graph_->passes()[order[i]].name;
        const double milliseconds = double(stamps[2 * i + 1] - stamps[2 * i]) * device_.timestampPeriod() * 1e-6;
        times_[name] = milliseconds;
        totalTimes_[name] += milliseconds;
    }
}

const Buffer* Executor::latest(uint32_t pass, uint32_t output) const
{
    for (const auto& resource : resources_)
        if (resource.plan.pass == pass && resource.plan.output == output)
            return &resource.copies[resource.current];
    return nullptr;
}

std::map<std::string, uint64_t> Executor::memory() const
{
    std::map<std::string, uint64_t> bytes;
    for (const auto& resource : resources_) {
        const auto& pass = graph_->passes()[resource.plan.pass];
        bytes[pass.name + "." + pass.interface.outputs()[resource.plan.output].name] =
            resource.copies[0].bytes() + resource.copies[1].bytes();
    }
    return bytes;
}

}  // namespace restirpg
