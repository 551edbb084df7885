// The GPU-free half of the render graph: read a description, check it, order it, cull it, plan its resources.
#pragma once

#include "graph/description.h"
#include "graph/plugins.h"

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

namespace restirpg {

/// A graph file (.py, evaluated by pythonInterpreter(), or .json) as JSON, checked for shape only: the schema stands in
/// scripts/restirpg/graph.py. Throws Error, located in the file. What a Python file prints goes to the log.
nlohmann::json readGraphFile(const std::filesystem::path& file);

/// An edge into an input port.
struct Edge {
    uint32_t source;  ///< index into Graph::passes
    uint32_t output;  ///< index into the source's outputs
    uint32_t target;
    uint32_t input;
    bool delayed;  ///< reads the resource as it was one frame ago
};

struct GraphPass {
    std::string name;  ///< in the graph: "paths"
    std::string type;  ///< the plugin: "PathTracerGuided"
    Location location;  ///< of its Graph.add
    const PluginEntry* entry = nullptr;
    std::unique_ptr<Pass> pass;
    Interface interface;
    bool live = false;  ///< reachable from the graph's outputs, over all edges
};

/// "pass 'paths' (PathTracerGuided)"
std::string label(const GraphPass& pass);
/// The same after its place: "graphs/restir_pg.py:11: pass 'paths' (PathTracerGuided)".
std::string placeOf(const GraphPass& pass);

/// "pass.port" or "pass.knob"
inline std::string pathOf(const GraphPass& pass, const std::string& name)
{
    return pass.name + "." + name;
}
/// Its two names; the second is empty where there is no dot.
std::pair<std::string, std::string> splitPath(const std::string& path);

/// A named output of the graph.
struct GraphOutput {
    std::string name;
    uint32_t pass;
    uint32_t output;
};

/// A resource the executor allocates: one output port of a live pass that somebody reads.
struct PlannedResource {
    uint32_t pass;
    uint32_t output;
    bool delayed;  ///< somebody reads last frame's value: two copies, alternating
    uint32_t copies() const { return delayed ? 2 : 1; }
};

/// A parsed, checked and ordered graph.
class Graph {
public:
    /// From a description (readGraphFile) and the plugins at hand. Throws Error with every mistake found, each in a
    /// line located in the graph file and, where there is more to say, an indented line of help.
    Graph(nlohmann::json description, const Plugins& plugins);
    Graph(const Graph&) = delete;  // its passes ask it for the sizes of what is wired to them
    Graph& operator=(const Graph&) = delete;

    const std::string& name() const { return name_; }
    std::vector<GraphPass>& passes() { return passes_; }
    const std::vector<GraphPass>& passes() const { return passes_; }
    const std::vector<Edge>& edges() const { return edges_; }
    const std::vector<GraphOutput>& outputs() const { return outputs_; }
    /// Make the output `name` readable: one of the graph's outputs, or any port of a pass, "pass.port", or "port" where
    /// only one pass that runs has it. Before the graph is given to an executor; what nobody names here, wires or
    /// outputs costs nothing. Throws Error, naming what there is.
    void addOutput(const std::string& name);
    const std::vector<uint32_t>& order() const { return order_; }  ///< live passes in execution order
    const std::vector<PlannedResource>& resources() const { return resources_; }

    /// A live or dead pass by name; nullptr when there is none.
    GraphPass* find(const std::string& name);

    /// Throws Error with every place where knobs, sizes and wiring, each right by itself, do not go together. Done when
    /// the graph is loaded; knobs may disagree while they are being changed, so again before a frame.
    void check() const;

    /// Another instance of a pass, with its wiring and knobs.
    GraphPass copyOf(const GraphPass& pass) const;

    /// The knob "pass.knob". Throws Error in one line, naming what there is and the nearest name.
    Knob& knob(const std::string& path);
    /// The same with its pass.
    std::pair<GraphPass&, Knob&> knobOf(const std::string& path);
    /// Set "pass.knob" from text, as `--set` has it; throws as knob(), and when the value does not suit.
    void setKnobFromText(const std::string& path, const std::string& text);
    /// Set "pass.knob" from a value; throws as knob(), and when the value does not suit.
    void setKnob(const std::string& path, const nlohmann::json& value);
    /// `knob` of every pass that has it. Throws Error when the value does not suit one of them.
    std::vector<Knob*> knobsFor(const std::string& knob, const nlohmann::json& value);
    /// Set `knob` on every pass that has it; the number of passes that do. Throws Error, having set none, when the
    /// value does not suit.
    uint32_t setKnobEverywhere(const std::string& knob, const nlohmann::json& value);

    /// The files that there are among the values of text knobs: what passes read.
    std::vector<std::filesystem::path> namedFiles() const;

    /// The description with the knobs as they are now: what an EXR header carries, and a valid graph file.
    nlohmann::json description() const;

    /// Graphviz text.
    std::string dot() const;

private:
    void plan();
    void connectPorts();

    std::string name_;
    nlohmann::json description_;
    std::vector<GraphPass> passes_;
    std::vector<Edge> edges_;
    std::vector<GraphOutput> outputs_;
    std::vector<uint32_t> sorted_;  ///< all passes in execution order
    std::vector<uint32_t> order_;
    std::vector<PlannedResource> resources_;
};

}  // namespace restirpg
