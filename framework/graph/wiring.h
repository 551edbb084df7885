// From a description to passes, edges and knob values, checked against what each pass declares.
#pragma once

#include "graph/graph.h"

namespace restirpg {

struct Wiring {
    std::vector<GraphPass> passes;  ///< one for each described pass; `pass` is null where its type is unknown
    std::vector<Edge> edges;
    std::vector<GraphOutput> outputs;
};

/// Create the passes and wire them. Every mistake is reported; what is wrong is left out of the result.
Wiring wire(const Description& description, const Plugins& plugins, Mistakes& mistakes);

/// The knob of a pass; nullptr when it has none of that name.
Knob* findKnob(GraphPass& pass, const std::string& name);

/// The names of ports, knobs or passes, in order.
template <typename Declarations>
std::vector<std::string> namesOf(const Declarations& declarations)
{
    std::vector<std::string> names;
    for (const auto& declaration : declarations)
        names.push_back(declaration.name);
    return names;
}

}  // namespace restirpg
