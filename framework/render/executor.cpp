#include "render/executor.h"

#include <algorithm>

namespace restirpg {

Executor::Executor(Device& device, std::unique_ptr<Graph> graph, uint32_t width, uint32_t height,
                   const CompileProgress& progress)
    : device_(device), graph_(std::move(graph)), width_(width), height_(height)
{
    graph_->check();
    uint64_t bytes = 0;
    for (const auto& plan : graph_->resources())
        bytes += plan.copies() * copyBytes(plan, graph_->passes()[plan.pass]);
    checkFits(device_, fmt::format("graph '{}'", graph_->name()), width_, height_, bytes);
    for (const auto& plan : graph_->resources())
        resources_.push_back({plan, allocate(plan, graph_->passes()[plan.pass])});
    constants_ = device_.createBuffer(sizeof(FrameConstants), "frame constants");
    connect();
    for (uint32_t pass : graph_->order())
        build(graph_->passes()[pass]);
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

/// The bytes of one buffer of an output of `pass`, whose knobs tell its size.
uint64_t Executor::copyBytes(const PlannedResource& plan, const GraphPass& pass) const
{
    constexpr uint64_t MOST_ITEMS = (1ull << 32) - 1;
    const auto& port = pass.interface.outputs()[plan.output];
    const uint64_t bytes = port.type.bytes(width_, height_);
    if (port.type.itemBytes > 0 && bytes / port.type.itemBytes > MOST_ITEMS)
        fail("{}: the output '{}' has {} items at {}x{} pixels, of which kernels can count {}; set a knob that it "
             "follows lower, or render a window",
             placeOf(pass), port.name, bytes / port.type.itemBytes, width_, height_, MOST_ITEMS);
    return bytes;
}

Executor::Copies Executor::allocate(const PlannedResource& plan, const GraphPass& pass)
{
    const uint64_t bytes = copyBytes(plan, pass);
    checkFits(device_, placeOf(pass), width_, height_, plan.copies() * bytes);
    Copies copies;
    for (uint32_t copy = 0; copy < plan.copies(); ++copy)
        copies[copy] = device_.createBuffer(bytes, pathOf(pass, pass.interface.outputs()[plan.output].name));
    return copies;
}

void Executor::build(GraphPass& pass)
{
    try {
        runPlugin(placeOf(pass) + ": ", [&] { pass.pass->build(device_); });
    } catch (...) {
        device_.dropKernels();  // nobody waits for those of the passes before
        throw;
    }
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

void Executor::setKnob(GraphPass& pass, const std::string& knob, const nlohmann::json& value)
{
    const auto& knobs = pass.interface.knobs();
    const auto index =
        std::find_if(knobs.begin(), knobs.end(), [&](const Knob& k) { return k.name == knob; }) - knobs.begin();
    const auto set = [&](GraphPass& target) {
        runPlugin(label(pass) + ": ", [&] { target.interface.knobs()[index].set(value); });
    };
    if (!knobs[index].structural || !pass.live) {
        set(pass);
        return;
    }
    GraphPass fresh = graph_->copyOf(pass);
    set(fresh);
    replace(pass, std::move(fresh));
    cut();
}

/// Buffers for the outputs of other passes that follow the size of one of `changed`. Passes learn such sizes as they
/// record, so none is built anew.
std::vector<Executor::Replacement> Executor::allocateFollowing(const GraphPass& changed)
{
    std::vector<Replacement> outputs;
    for (auto& resource : resources_) {
        const auto& pass = graph_->passes()[resource.plan.pass];
        if (&pass != &changed &&
            resource.copies[0].bytes() != pass.interface.outputs()[resource.plan.output].type.bytes(width_, height_))
            outputs.emplace_back(&resource, allocate(resource.plan, pass));
    }
    return outputs;
}

/// Build `fresh` with outputs of its own, then put both in place of `pass` and its outputs.
void Executor::replace(GraphPass& pass, GraphPass fresh)
{
    std::vector<Replacement> outputs;
    for (auto& resource : resources_)
        if (&graph_->passes()[resource.plan.pass] == &pass)
            outputs.emplace_back(&resource, allocate(resource.plan, fresh));
    for (auto& [resource, copies] : outputs)
        fresh.interface.outputs()[resource->plan.output].target->resource = &copies[resource->current];
    build(fresh);
    runPlugin(placeOf(fresh) + ": ", [&] { device_.finishKernels(); });
    std::swap(pass, fresh);  // other passes ask the graph for the sizes that they follow
    std::vector<Replacement> following;
    try {
        following = allocateFollowing(pass);
    } catch (...) {
        std::swap(pass, fresh);
        throw;
    }
    for (auto* list : {&outputs, &following})
        for (auto& [resource, copies] : *list)
            resource->copies = std::move(copies);
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
    graph_->check();
    constants.frame = frame_;
    constants.reset = frame_ == 0;
    connect();
    try {
        device_.submit([&](VkCommandBuffer commands) {
            vkCmdUpdateBuffer(commands, constants_.handle(), 0, sizeof constants, &constants);
            record(commands, bindings);
        });
    } catch (...) {
        connect();  // back: the frame before is still the last one
        throw;
    }
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
        runPlugin(placeOf(pass) + ": ", [&] { pass.pass->record(frame); });
        scratch_[pass.name] = frame.takeScratchBytes();
        vkCmdWriteTimestamp(commands, VK_PIPELINE_STAGE_BOTTOM_OF_PIPE_BIT, queries_, 2 * i + 1);
        device_.endLabel(commands);
    }
}

void Executor::readTimes()
{
    const auto& order = graph_->order();
    std::vector<uint64_t> stamps(2 * order.size());
    device_.logical().checkWork(vkGetQueryPoolResults(device_.handle(), queries_, 0, uint32_t(stamps.size()),
                                                      stamps.size() * sizeof(uint64_t), stamps.data(), sizeof(uint64_t),
                                                      VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
                                "vkGetQueryPoolResults");
    for (size_t i = 0; i < order.size(); ++i) {
        const std::string& name = graph_->passes()[order[i]].name;
        const double milliseconds = device_.logical().milliseconds(stamps[2 * i], stamps[2 * i + 1]);
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
        bytes[pathOf(pass, pass.interface.outputs()[resource.plan.output].name)] =
            resource.copies[0].bytes() + resource.copies[1].bytes();
    }
    for (const auto& [pass, size] : scratch_)
        if (size > 0)
            bytes[pass + ".scratch"] += size;
    return bytes;
}

}  // namespace restirpg
