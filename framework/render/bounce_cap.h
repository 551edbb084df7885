// The bounce cap that a scene's author asks for, and the user's in its place.
#pragma once

#include "graph/graph.h"
#include "scene/scene.h"

#include <cstdint>
#include <optional>

namespace restirpg {

/// Set the knob "bounces" of every pass that has it: to `wanted`, else to the scene's own cap, else not at all. Returns
/// the number of passes.
uint32_t capBounces(Graph& graph, const Scene& scene, std::optional<uint32_t> wanted);

/// Graph::check after that, once all knobs are set. Where a cap is the scene's own, each Error of both says so in an
/// indented line.
void checkCapped(const Graph& graph, const Scene& scene, std::optional<uint32_t> wanted);

}  // namespace restirpg
