// restirpg graph GRAPH [--dot]: check a graph file and print what it means.
#include "app/commands.h"

#include "core/error.h"
#include "core/table.h"
#include "graph/graph.h"

#include <fmt/format.h>

#include <algorithm>

namespace restirpg {
namespace {

struct GraphOptions {
    std::string file;
    bool dot = false;
};

std::string outputName(const Graph& graph, uint32_t pass, uint32_t output)
{
    return pathOf(graph.passes()[pass], graph.passes()[pass].interface.outputs()[output].name);
}

void printOrder(const Graph& graph)
{
    Table table({"#", "pass", "type", "at"});
    for (uint32_t i = 0; i < graph.order().size(); ++i) {
        const auto& pass = graph.passes()[graph.order()[i]];
        table.add({std::to_string(i), pass.name, pass.type, escaped(pass.location.text())});
    }
    for (const auto& pass : graph.passes())
        if (!pass.live)
            table.add({"-", pass.name, pass.type, escaped(pass.location.text()) + ", culled: no output needs it"});
    fmt::print("order\n{}", table.text());
}

void printEdges(const Graph& graph)
{
    Table table({"from", "to", "type", ""});
    for (const auto& edge : graph.edges()) {
        const auto& target = graph.passes()[edge.target];
        const auto& input = target.interface.inputs()[edge.input];
        table.add({outputName(graph, edge.source, edge.output), pathOf(target, input.name), input.type.name,
                   edge.delayed ? "one frame later" : ""});
    }
    fmt::print("\nedges\n{}", table.text());
}

void printResources(const Graph& graph)
{
    Table table({"resource", "type", "size", "copies"});
    for (const auto& resource : graph.resources()) {
        const auto& type = graph.passes()[resource.pass].interface.outputs()[resource.output].type;
        table.add({outputName(graph, resource.pass, resource.output), type.name, type.sizeText(),
                   std::to_string(resource.copies())});
    }
    fmt::print("\nresources\n{}", table.text());
}

void printOutputs(const Graph& graph)
{
    Table table({"output", "port", "type"});
    for (const auto& output : graph.outputs())
        table.add({output.name, outputName(graph, output.pass, output.output),
                   graph.passes()[output.pass].interface.outputs()[output.output].type.name});
    fmt::print("\noutputs\n{}", table.text());
}

}  // namespace

void addGraphCommand(CLI::App& app)
{
    auto* command = app.add_subcommand("graph", "Check a graph file; print its order, edges, resources and outputs");
    auto options = std::make_shared<GraphOptions>();
    command->add_option("GRAPH", options->file, "Graph file (.py or .json)")->required();
    command->add_flag("--dot", options->dot, "Print it for Graphviz instead");
    command->callback([options] {
        const Graph graph(readGraphFile(options->file), Plugins());
        if (options->dot) {
            fmt::print("{}", graph.dot());
            return;
        }
        fmt::print("{}\n\n", escaped(graph.name()));
        printOrder(graph);
        printEdges(graph);
        printResources(graph);
        printOutputs(graph);
    });
}

}  // namespace restirpg
