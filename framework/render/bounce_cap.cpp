#include "render/bounce_cap.h"

#include "core/error.h"

#include <algorithm>

namespace restirpg {
namespace {

/// Has every pass that has a cap this one?
bool areCapped(const Graph& graph, uint32_t cap)
{
    return std::all_of(graph.passes().begin(), graph.passes().end(), [&](const GraphPass& pass) {
        const auto& knobs = pass.interface.knobs();
        return std::all_of(knobs.begin(), knobs.end(),
                           [&](const Knob& knob) { return knob.name != "bounces" || knob.get() == cap; });
    });
}

/// Run `action`; its Error about a cap names the scene when the cap is the scene's `own`.
template <typename Action>
void namingScene(const Scene& scene, bool own, Action action)
{
    try {
        action();
    } catch (const Error& error) {
        const std::string text = error.what();
        if (!own || text.find("'bounces'") == std::string::npos)
            throw;
        throw Error(fmt::format("{}: asset.extras.restirpg.bounces is {}: {}; give another cap: bounces=N in Python, "
                                "--bounces N on the command line",
                                escaped(scene.file.string()), *scene.bounceCap, text));
    }
}

}  // namespace

uint32_t capBounces(Graph& graph, const Scene& scene, std::optional<uint32_t> wanted)
{
    const auto cap = wanted ? wanted : scene.bounceCap;
    uint32_t passes = 0;
    if (cap)
        namingScene(scene, !wanted, [&] { passes = graph.setKnobEverywhere("bounces", *cap); });
    return passes;
}

void checkCapped(const Graph& graph, const Scene& scene, std::optional<uint32_t> wanted)
{
    // One that was set since is not the scene's.
    const bool own = !wanted && scene.bounceCap && areCapped(graph, *scene.bounceCap);
    namingScene(scene, own, [&] { graph.check(); });
}

}  // namespace restirpg
