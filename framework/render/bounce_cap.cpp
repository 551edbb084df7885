#include "render/bounce_cap.h"

#include "core/error.h"

namespace restirpg {
namespace {

/// Run `action`, which applies the scene's own cap where there is no other `wanted`.
template <typename Action>
void namingScene(const Scene& scene, std::optional<uint32_t> wanted, Action action)
{
    try {
        action();
    } catch (const Error& error) {
        const std::string text = error.what();
        if (wanted || !scene.bounceCap || text.find("'bounces'") == std::string::npos)
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
        namingScene(scene, wanted, [&] { passes = graph.setKnobEverywhere("bounces", *cap); });
    return passes;
}

void checkCapped(const Graph& graph, const Scene& scene, std::optional<uint32_t> wanted)
{
    namingScene(scene, wanted, [&] { graph.check(); });
}

}  // namespace restirpg
