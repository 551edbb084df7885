// Ordering, culling and planning of a wired graph: pure functions of passes and edges.
#pragma once

#include "graph/graph.h"

namespace restirpg {

/// All passes in topological order of the undelayed edges, ties in file order (Kahn's algorithm). Every undelayed cycle
/// met is reported, with the passes on it.
std::vector<uint32_t> topologicalOrder(const std::vector<GraphPass>& passes, const std::vector<Edge>& edges,
                                       Mistakes& mistakes);

/// Whether each pass is reachable from the outputs, against all edges: what is read one frame later must be made too.
std::vector<bool> reachable(size_t passCount, const std::vector<Edge>& edges, const std::vector<GraphOutput>& outputs);

/// The resources of the live passes, by pass and output.
std::vector<PlannedResource> planResources(const std::vector<GraphPass>& passes, const std::vector<Edge>& edges,
                                           const std::vector<GraphOutput>& outputs);

}  // namespace restirpg
