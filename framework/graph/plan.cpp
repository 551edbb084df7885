#include "graph/plan.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <map>

namespace restirpg {
namespace {

/// One cycle among the passes not yet done, in the order data flows. Each of those passes has an undelayed edge from
/// another that is not done, so that walking backwards must come around.
std::vector<uint32_t> findCycle(const std::vector<Edge>& edges, const std::vector<bool>& done)
{
    std::vector<uint32_t> walk{uint32_t(std::find(done.begin(), done.end(), false) - done.begin())};
    while (true) {
        const auto edge = std::find_if(edges.begin(), edges.end(), [&](const Edge& e) {
            return !e.delayed && e.target == walk.back() && !done[e.source];
        });
        const auto seen = std::find(walk.begin(), walk.end(), edge->source);
        if (seen != walk.end()) {
            std::vector<uint32_t> cycle(seen, walk.end());
            std::reverse(cycle.begin(), cycle.end());
            std::rotate(cycle.begin(), std::min_element(cycle.begin(), cycle.end()), cycle.end());
            return cycle;
        }
        walk.push_back(edge->source);
    }
}

void reportCycle(const std::vector<GraphPass>& passes, const std::vector<Edge>& edges,
                 const std::vector<uint32_t>& cycle, Mistakes& mistakes)
{
    std::vector<std::string> names, inputs;
    for (size_t i = 0; i < cycle.size(); ++i) {
        const uint32_t source = cycle[i], target = cycle[(i + 1) % cycle.size()];
        names.push_back(passes[source].name);
        for (const auto& edge : edges)
            if (!edge.delayed && edge.source == source && edge.target == target)
                inputs.push_back(pathOf(passes[target], passes[target].interface.inputs()[edge.input].name));
    }
    names.push_back(names.front());
    mistakes.add(passes[cycle.front()].location, fmt::format("cycle without a delay: {}", fmt::join(names, " -> ")),
                 fmt::format("wire one of these inputs with prev(): {}", fmt::join(inputs, ", ")));
}

}  // namespace

std::vector<uint32_t> topologicalOrder(const std::vector<GraphPass>& passes, const std::vector<Edge>& edges,
                                       Mistakes& mistakes)
{
    std::vector<bool> done(passes.size(), false);
    const auto isReady = [&](uint32_t pass) {
        return !done[pass] && std::none_of(edges.begin(), edges.end(), [&](const Edge& e) {
            return !e.delayed && e.target == pass && !done[e.source];
        });
    };
    std::vector<uint32_t> order;
    while (order.size() < passes.size()) {
        uint32_t next = 0;
        while (next < passes.size() && !isReady(next))
            ++next;
        if (next < passes.size()) {
            done[next] = true;
            order.push_back(next);
            continue;
        }
        // Take the cycle out and go on, to find what else is wrong.
        const auto cycle = findCycle(edges, done);
        reportCycle(passes, edges, cycle, mistakes);
        for (const uint32_t pass : cycle) {
            done[pass] = true;
            order.push_back(pass);
        }
    }
    return order;
}

std::vector<bool> reachable(size_t passCount, const std::vector<Edge>& edges, const std::vector<GraphOutput>& outputs)
{
    std::vector<bool> live(passCount, false);
    std::vector<uint32_t> open;
    const auto visit = [&](uint32_t pass) {
        if (!live[pass])
            open.push_back(pass);
        live[pass] = true;
    };
    for (const auto& output : outputs)
        visit(output.pass);
    while (!open.empty()) {
        const uint32_t pass = open.back();
        open.pop_back();
        for (const auto& edge : edges)
            if (edge.target == pass)
                visit(edge.source);
    }
    return live;
}

std::vector<PlannedResource> planResources(const std::vector<GraphPass>& passes, const std::vector<Edge>& edges,
                                           const std::vector<GraphOutput>& outputs)
{
    std::map<std::pair<uint32_t, uint32_t>, PlannedResource> resources;
    const auto resource = [&](uint32_t pass, uint32_t output) -> PlannedResource& {
        return resources.try_emplace({pass, output}, PlannedResource{pass, output, false}).first->second;
    };
    for (const auto& edge : edges)
        if (passes[edge.target].live)
            resource(edge.source, edge.output).delayed |= edge.delayed;
    for (const auto& output : outputs)
        resource(output.pass, output.output);

    std::vector<PlannedResource> result;
    for (const auto& [port, planned] : resources)
        result.push_back(planned);
    return result;
}

}  // namespace restirpg
