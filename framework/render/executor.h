// The GPU half of the render graph: allocates what the plan asks for, runs the passes in order, measures them.
#pragma once

#include "gpu/binding_set.h"
#include "graph/graph.h"
#include "render/frame.h"
#include "shaders/frame_types.h"

#include <array>
#include <map>
#include <memory>
#include <string>

namespace restirpg {

class Executor {
public:
    /// Build every live pass and allocate the graph's resources for the image size.
    Executor(Device& device, std::unique_ptr<Graph> graph, uint32_t width, uint32_t height,
             const CompileProgress& progress);
    ~Executor();
    Executor(const Executor&) = delete;
    Executor& operator=(const Executor&) = delete;

    /// Run one frame. `constants.frame` and `constants.reset` are the executor's to fill in.
    void run(FrameConstants constants, const BindingSet& bindings);

    /// The next frame is a first frame: delayed inputs are zeroed.
    void cut();
    uint32_t frame() const { return frame_; }  ///< frames run since the last cut

    /// Set a knob of a pass. A structural one builds a new instance with new outputs, which takes the pass's place and
    /// implies a cut; when that fails, nothing has changed.
    void setKnob(GraphPass& pass, const std::string& knob, const nlohmann::json& value);

    Graph& graph() { return *graph_; }
    const Graph& graph() const { return *graph_; }

    /// The buffer of an output as the last frame left it; nullptr when nobody reads it.
    const Buffer* latest(uint32_t pass, uint32_t output) const;

    const std::map<std::string, double>& times() const { return times_; }  ///< ms a pass, last frame
    const std::map<std::string, double>& totalTimes() const { return totalTimes_; }  ///< ms a pass since the last cut
    /// Bytes per "pass.output" and, of what passes kept within the last frame, per "pass.scratch".
    std::map<std::string, uint64_t> memory() const;

private:
    /// An output's buffers: one, or two that alternate when somebody reads last frame's value.
    struct Resource {
        PlannedResource plan;
        std::array<Buffer, 2> copies;
        uint32_t current = 0;  ///< the copy the last (or running) frame writes
    };

    using Copies = std::array<Buffer, 2>;
    uint64_t copyBytes(const PlannedResource& plan, const GraphPass& pass) const;
    Copies allocate(const PlannedResource& plan, const GraphPass& pass);
    void build(GraphPass& pass);
    using Replacement = std::pair<Resource*, Copies>;  ///< what takes the place of its copies
    std::vector<Replacement> allocateFollowing(const GraphPass& changed);
    void replace(GraphPass& pass, GraphPass fresh);
    void connect();
    void record(VkCommandBuffer commands, const BindingSet& bindings);
    void readTimes();

    Device& device_;
    std::unique_ptr<Graph> graph_;
    uint32_t width_, height_;
    uint32_t frame_ = 0;
    std::vector<Resource> resources_;
    Buffer constants_;
    VkQueryPool queries_ = VK_NULL_HANDLE;
    std::map<std::string, double> times_;
    std::map<std::string, double> totalTimes_;
    std::map<std::string, uint64_t> scratch_;  ///< bytes per pass, last frame
};

}  // namespace restirpg
