#include "render/bounce_cap.h"

#include "core/error.h"

#include <algorithm>

namespace restirpg {
namespace {

/// Has a pass this cap?
bool isCapped(const Graph& graph, uint32_t cap)
{
    return std::any_of(graph.passes().begin(), graph.passes().end(), [&](const GraphPass& pass) {
        const auto& knobs = pass.interface.knobs();
        return std::any_of(knobs.begin(), knobs.end(),
                           [&](const Knob& knob) { return knob.name == "bounces" && knob.get() == cap; });
    });
}

/// Run `action`; where the cap is the scene's own, its Error has a line that says so.
template <typename Action>
void namingCap(const Scene& scene, bool own, Action action)
{
    try {
        action();
    } catch (const Error& error) {
        if (!own)
            throw;
        throw Error(fmt::format("{}\n    bounce cap {} is the scene's; --bounces replaces it (bounces= in Python)",
                                error.what(), *scene.bounceCap));
    }
}

}  // namespace

uint32_t capBounces(Graph& graph, const Scene& scene, std::optional<uint32_t> wanted)
{
    const auto cap = wanted ? wanted : scene.bounceCap;
    uint32_t passes = 0;
    if (cap)
        namingCap(scene, !wanted, [&] { passes = graph.setKnobEverywhere("bounces", *cap); });
    return passes;
}

void checkCapped(const Graph& graph, const Scene& scene, std::optional<uint32_t> wanted)
{
    // One that was set since is not the scene's.
    const bool own = !wanted && scene.bounceCap && isCapped(graph, *scene.bounceCap);
    namingCap(scene, own, [&] { graph.check(); });
}

}  // namespace restirpg
