#include "graph/graph.h"

#include "core/error_kinds.h"
#include "core/nearest.h"
#include "graph/plan.h"
#include "graph/wiring.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <tuple>

namespace restirpg {
namespace {

/// "; did you mean 'x'?" or empty.
std::string guess(const std::string& asked, const std::vector<std::string>& names)
{
    const auto text = didYouMean(asked, names);
    return text.empty() ? text : "; " + text;
}

/// The knobs of one name and different values of two passes: "'cells' (1024 and 2048)".
std::string differingKnobs(const GraphPass& a, const GraphPass& b)
{
    std::vector<std::string> texts;
    for (const auto& knob : a.interface.knobs())
        for (const auto& other : b.interface.knobs())
            if (knob.name == other.name && knob.get() != other.get())
                texts.push_back(
                    fmt::format("'{}' ({} and {})", knob.name, jsonText(knob.get()), jsonText(other.get())));
    return fmt::format("{}", fmt::join(texts, ", "));
}

/// The reader must expect as many bytes as there are: it would read beyond the end, or a layout that is not there.
void checkSize(const GraphPass& source, uint32_t output, const GraphPass& target, uint32_t input, Mistakes& mistakes)
{
    constexpr uint32_t WIDTH = 61, HEIGHT = 37;  // of any image: sizes that agree do so for all
    const auto& made = source.interface.outputs()[output];
    const auto& wanted = target.interface.inputs()[input];
    const uint64_t expected = wanted.type.bytes(WIDTH, HEIGHT);
    if (expected == 0 || expected == made.type.bytes(WIDTH, HEIGHT))
        return;
    const auto knobs = differingKnobs(target, source);
    mistakes.add(target.location,
                 fmt::format("input '{}' of {} reads {}, but {}.{} of {} has {}", wanted.name, label(target),
                             wanted.type.sizeText(), source.name, made.name, label(source), made.type.sizeText()),
                 knobs.empty() ? "" : fmt::format("give both the same knobs: {}", knobs));
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
    sorted_ = topologicalOrder(passes_, edges_, mistakes);
    mistakes.raise();
    plan();
    check();
}

/// Which passes run, in which order, and what is allocated for the present outputs.
void Graph::plan()
{
    const auto live = reachable(passes_.size(), edges_, outputs_);
    order_.clear();
    for (const uint32_t pass : sorted_) {
        passes_[pass].live = live[pass];
        if (live[pass])
            order_.push_back(pass);
    }
    resources_ = planResources(passes_, edges_, outputs_);
    connectPorts();
}

void Graph::addOutput(const std::string& name)
{
    std::vector<std::string> names;
    for (const auto& output : outputs_)
        names.push_back(output.name);
    if (std::find(names.begin(), names.end(), name) != names.end())
        return;
    std::vector<GraphOutput> found;
    std::vector<std::string> others;  // of passes that run
    for (uint32_t p = 0; p < passes_.size(); ++p)
        for (uint32_t o = 0; o < passes_[p].interface.outputs().size(); ++o) {
            const std::string port = passes_[p].interface.outputs()[o].name, path = pathOf(passes_[p], port);
            if (path == name || (port == name && passes_[p].live))
                found.push_back({port, p, o});
            if (passes_[p].live && passes_[p].interface.outputs()[o].type.channels > 0)
                others.push_back(path);
        }
    if (found.empty())
        failAs<WrongValue>("graph '{}' has no output '{}'; it has: {}; and, of its passes: {}", name_, name,
                           fmt::join(names, ", "), fmt::join(others, ", "));
    if (found.size() > 1) {
        std::vector<std::string> paths;
        for (const auto& output : found)
            paths.push_back(pathOf(passes_[output.pass], output.name));
        failAs<WrongValue>("graph '{}' has several ports '{}'; name one of: {}", name_, name, fmt::join(paths, ", "));
    }
    GraphOutput added = found.front();
    description_["outputs"].push_back({{"name", name}, {"pass", passes_[added.pass].name}, {"output", added.name}});
    added.name = name;
    outputs_.push_back(added);
    plan();
    check();
}

/// Tell the passes which of their ports are wired, and to what.
void Graph::connectPorts()
{
    for (const auto& edge : edges_) {
        auto& input = *passes_[edge.target].interface.inputs()[edge.input].target;
        input.wired = true;
        input.module = passes_[edge.source].interface.outputs()[edge.output].type.module;
        input.pixelBytes = [this, edge] {
            return passes_[edge.source].interface.outputs()[edge.output].type.bytes(1, 1);
        };
    }
    for (const auto& resource : resources_)
        passes_[resource.pass].interface.outputs()[resource.output].target->wired = true;
}

void Graph::check() const
{
    Mistakes mistakes;
    const auto askAll = [&](const std::function<void(const GraphPass&)>& ask) {
        for (const uint32_t index : order_) {
            const auto& pass = passes_[index];
            try {
                runPlugin("", [&] { ask(pass); });
            } catch (const Error& error) {
                mistakes.add(pass.location, label(pass) + ": " + error.what());
            }
        }
    };
    askAll([](const GraphPass& pass) {
        for (const auto& output : pass.interface.outputs())
            output.type.bytes(1, 1);  // a plugin's function, too
        for (const auto& input : pass.interface.inputs())
            input.type.bytes(1, 1);
    });
    mistakes.raise();
    for (const auto& edge : edges_)
        if (passes_[edge.target].live)
            checkSize(passes_[edge.source], edge.output, passes_[edge.target], edge.input, mistakes);
    askAll([](const GraphPass& pass) { pass.pass->check(); });
    mistakes.raise();
}

GraphPass Graph::copyOf(const GraphPass& pass) const
{
    GraphPass copy{pass.name, pass.type, pass.location, pass.entry};
    copy.live = pass.live;
    std::tie(copy.pass, copy.interface) = runPlugin(label(pass) + " ", [&] { return instantiate(*pass.entry); });
    for (size_t i = 0; i < pass.interface.inputs().size(); ++i) {
        copy.interface.inputs()[i].target->wired = pass.interface.inputs()[i].target->wired;
        copy.interface.inputs()[i].target->module = pass.interface.inputs()[i].target->module;
        copy.interface.inputs()[i].target->pixelBytes = pass.interface.inputs()[i].target->pixelBytes;
    }
    for (size_t i = 0; i < pass.interface.outputs().size(); ++i)
        copy.interface.outputs()[i].target->wired = pass.interface.outputs()[i].target->wired;
    for (size_t i = 0; i < pass.interface.knobs().size(); ++i)
        copy.interface.knobs()[i].set(pass.interface.knobs()[i].get());
    return copy;
}

GraphPass* Graph::find(const std::string& name)
{
    const auto found = std::find_if(passes_.begin(), passes_.end(), [&](const GraphPass& p) { return p.name == name; });
    return found == passes_.end() ? nullptr : &*found;
}

std::pair<std::string, std::string> splitPath(const std::string& path)
{
    const auto dot = path.find('.');
    return {path.substr(0, dot), dot == std::string::npos ? "" : path.substr(dot + 1)};
}

std::pair<GraphPass&, Knob&> Graph::knobOf(const std::string& path)
{
    const auto [passName, knobName] = splitPath(path);
    if (knobName.empty())
        failAs<WrongValue>("'{}' names no knob; write PASS.KNOB, as in {}.KNOB", path, passes_.front().name);
    auto* pass = find(passName);
    if (!pass) {
        const auto names = namesOf(passes_);
        failAs<WrongValue>("graph '{}' has no pass '{}'; passes: {}{}", name_, passName, fmt::join(names, ", "),
                           guess(passName, names));
    }
    auto* found = findKnob(*pass, knobName);
    if (!found) {
        const auto names = namesOf(pass->interface.knobs());
        failAs<WrongValue>("{} has no knob '{}'; knobs: {}{}", label(*pass), knobName,
                           names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", ")), guess(knobName, names));
    }
    return {*pass, *found};
}

Knob& Graph::knob(const std::string& path)
{
    return knobOf(path).second;
}

void Graph::setKnobFromText(const std::string& path, const std::string& text)
{
    const auto place = knobOf(path);
    runPlugin(label(place.first) + ": ", [&] { place.second.setFromText(text); });
}

void Graph::setKnob(const std::string& path, const nlohmann::json& value)
{
    const auto place = knobOf(path);
    runPlugin(label(place.first) + ": ", [&] { place.second.set(value); });
}

std::vector<Knob*> Graph::knobsFor(const std::string& knob, const nlohmann::json& value)
{
    std::vector<Knob*> knobs;
    for (auto& pass : passes_)
        if (auto* found = findKnob(pass, knob)) {
            runPlugin(label(pass) + ": ", [&] { found->check(value); });
            knobs.push_back(found);
        }
    return knobs;
}

uint32_t Graph::setKnobEverywhere(const std::string& knob, const nlohmann::json& value)
{
    const auto knobs = knobsFor(knob, value);
    for (auto* turned : knobs)
        turned->set(value);
    return uint32_t(knobs.size());
}

std::vector<std::filesystem::path> Graph::namedFiles() const
{
    std::vector<std::filesystem::path> files;
    std::error_code unreadable;
    for (const auto& pass : passes_)
        for (const auto& knob : pass.interface.knobs())
            if (knob.typeName() == "string")
                if (const auto text = knob.get().get<std::string>(); std::filesystem::is_regular_file(text, unreadable))
                    files.emplace_back(text);
    return files;
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
