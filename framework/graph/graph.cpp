#include "graph/graph.h"

#include "core/error.h"
#include "core/nearest.h"
#include "graph/plan.h"
#include "graph/wiring.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace restirpg {
namespace {

/// "; did you mean 'x'?" or empty.
std::string guess(const std::string& asked, const std::vector<std::string>& names)
{
    const auto text = didYouMean(asked, names);
    return text.empty() ? text : "; " + text;
}

/// Run `set`; a refusal gets the pass's name in front.
template <typename Set>
void setLocated(const GraphPass& pass, Set set)
{
    try {
        set();
    } catch (const Error& error) {
        fail("{}: {}", label(pass), error.what());
    }
}

}  // namespace

Graph::Graph(nlohmann::json description, const Plugins& plugins) : description_(std::move(description))
{
    Mistakes mistakes;
    const auto described = parseDescription(description_, "graph", mistakes);
    mistakes.raise();

    name_ = described.name;
    auto wiring = wire(described, plugins, mistakes);
    passes_ = std::move(wiring.passes);
    edges_ = std::move(wiring.edges);
    outputs_ = std::move(wiring.outputs);
    const auto all = topologicalOrder(passes_, edges_, mistakes);
    mistakes.raise();

    const auto live = reachable(passes_.size(), edges_, outputs_);
    for (const uint32_t pass : all) {
        passes_[pass].live = live[pass];
        if (live[pass])
            order_.push_back(pass);
    }
    resources_ = planResources(passes_, edges_, outputs_, order_);
}

GraphPass* Graph::find(const std::string& name)
{
    const auto found = std::find_if(passes_.begin(), passes_.end(), [&](const GraphPass& p) { return p.name == name; });
    return found == passes_.end() ? nullptr : &*found;
}

Knob& Graph::knob(const std::string& path)
{
    const auto dot = path.find('.');
    if (dot == std::string::npos)
        fail("'{}' names no knob; write PASS.KNOB, as in {}.KNOB", path, passes_.front().name);
    const std::string passName = path.substr(0, dot), knobName = path.substr(dot + 1);
    auto* pass = find(passName);
    if (!pass) {
        const auto names = namesOf(passes_);
        fail("graph '{}' has no pass '{}'; passes: {}{}", name_, passName, fmt::join(names, ", "),
             guess(passName, names));
    }
    auto* found = findKnob(*pass, knobName);
    if (!found) {
        const auto names = namesOf(pass->interface.knobs());
        fail("{} has no knob '{}'; knobs: {}{}", label(*pass), knobName,
             names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), guess(knobName, names));
    }
    return *found;
}

void Graph::setKnobFromText(const std::string& path, const std::string& text)
{
    auto& turned = knob(path);
    setLocated(*find(path.substr(0, path.find('.'))), [&] { turned.setFromText(text); });
}

void Graph::setKnob(const std::string& path, const nlohmann::json& value)
{
    auto& turned = knob(path);
    setLocated(*find(path.substr(0, path.find('.'))), [&] { turned.set(value); });
}

uint32_t Graph::setKnobEverywhere(const std::string& knob, const nlohmann::json& value)
{
    uint32_t count = 0;
    for (auto& pass : passes_) {
        auto* turned = findKnob(pass, knob);
        if (!turned)
            continue;
        setLocated(pass, [&] { turned->set(value); });
        ++count;
    }
    return count;
}

nlohmann::json Graph::description() const
{
    auto result = description_;
    for (size_t i = 0; i < passes_.size(); ++i) {
        auto& knobs = result["passes"][i]["knobs"] = nlohmann::json::object();
        for (const auto& knob : passes_[i].interface.knobs())
            knobs[knob.name] = knob.get();
    }
    return result;
}

}  // namespace restirpg
