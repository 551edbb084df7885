// A graph as Graphviz text.
#include "core/error.h"
#include "graph/graph.h"

#include <fmt/format.h>

namespace restirpg {
namespace {

/// The inside of a quoted Graphviz string.
std::string quoted(const std::string& text)
{
    std::string result;
    for (const char c : text) {
        if (c == '"' || c == '\\')
            result += '\\';
        result += c;
    }
    return result;
}

}  // namespace

std::string Graph::dot() const
{
    std::string text = fmt::format("digraph \"{}\" {{\n    node [shape=box];\n", quoted(escaped(name_)));
    for (const auto& pass : passes_)
        text += fmt::format("    \"{}\" [label=\"{}\\n{}\"{}];\n", pass.name, pass.name, pass.type,
                            pass.live ? "" : ", style=dotted");
    for (const auto& edge : edges_) {
        const auto& source = passes_[edge.source];
        const auto& target = passes_[edge.target];
        text += fmt::format("    \"{}\" -> \"{}\" [label=\"{} -> {}\"{}];\n", source.name, target.name,
                            source.interface.outputs()[edge.output].name, target.interface.inputs()[edge.input].name,
                            edge.delayed ? ", style=dashed, constraint=false" : "");
    }
    for (const auto& output : outputs_) {
        const auto& source = passes_[output.pass];
        text += fmt::format(
            "    \"output {0}\" [label=\"{0}\", shape=ellipse];\n    \"{1}\" -> \"output {0}\" [label=\"{2}\"];\n",
            output.name, source.name, source.interface.outputs()[output.output].name);
    }
    return text + "}\n";
}

}  // namespace restirpg
