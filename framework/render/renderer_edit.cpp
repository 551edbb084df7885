// What can be changed of a renderer that is there: knobs, the graph and its kernels, values of the scene.
#include "core/error_kinds.h"
#include "graph/wiring.h"
#include "render/executor.h"
#include "render/renderer.h"
#include "scene/edit.h"

#include <algorithm>

namespace restirpg {
namespace {

/// As the loader does, of matrices that a caller gave.
void deriveAgain(Scene& scene)
{
    try {
        deriveFromNodes(scene);
    } catch (const Error& error) {
        throw WrongValue(error.what());
    }
}

}  // namespace

nlohmann::json Renderer::knobs() const
{
    nlohmann::json all = nlohmann::json::object();
    for (const auto& pass : graph().passes())
        for (const auto& knob : pass.interface.knobs())
            all[pass.name][knob.name] = knob.get();
    return all;
}

nlohmann::json Renderer::knob(const std::string& path) const
{
    return executor_->graph().knob(path).get();
}

void Renderer::setKnob(const std::string& path, const nlohmann::json& value)
{
    const auto place = executor_->graph().knobOf(path);
    executor_->setKnob(place.first, place.second.name, value);
    turned_[path] = value;
}

uint32_t Renderer::setKnobEverywhere(const std::string& name, const nlohmann::json& value)
{
    auto& graph = executor_->graph();
    graph.knobsFor(name, value);  // a value that one of them refuses is refused before a structural one cuts
    std::vector<std::pair<std::string, nlohmann::json>> before;
    for (auto& pass : graph.passes())
        if (const Knob* knob = findKnob(pass, name))
            before.emplace_back(pathOf(pass, name), knob->get());
    const auto turned = turned_;
    for (size_t i = 0; i < before.size(); ++i) {
        try {
            setKnob(before[i].first, value);
        } catch (...) {  // it cannot be built with the value
            while (i-- > 0)
                setKnob(before[i].first, before[i].second);
            turned_ = turned;
            throw;
        }
    }
    return uint32_t(before.size());
}

nlohmann::json Renderer::parameters() const
{
    nlohmann::json all = nlohmann::json::object();
    for (const auto& parameter : parametersOf(*scene_, overrides_))
        all[parameter.path] = parameter.values;
    return all;
}

void Renderer::edit(const std::map<std::string, std::vector<double>>& values)
{
    auto overrides = overrides_;
    bool moves = false;
    for (const auto& [path, numbers] : values)
        if (const auto node = nodeOfPath(*scene_, path)) {
            overrides[*node].reset();
            moves = true;
        }
    if (edited_ && !moves) {
        editScene(*edited_, values);
        sceneGpu_->refresh();
    } else {
        auto scene = std::make_shared<Scene>(*scene_);
        editScene(*scene, values);
        if (moves)
            deriveAgain(*scene);
        sceneGpu_ = std::make_unique<SceneGpu>(*device_, *scene, poseNodes(*scene, time(), overrides),
                                               options_.energyCompensation);
        scene_ = edited_ = std::move(scene);
        overrides_ = std::move(overrides);
    }
    for (const auto& [path, numbers] : values)
        edits_[path] = numbers;
    cut();
}

void Renderer::reload(std::unique_ptr<Graph> graph)
{
    for (const auto& [path, value] : turned_) {
        const auto [passName, knobName] = splitPath(path);
        auto* pass = graph->find(passName);
        if (pass && findKnob(*pass, knobName))
            graph->setKnob(path, value);
    }
    executor_ =
        std::make_unique<Executor>(*device_, std::move(graph), window().width, window().height, options_.compiling);
}

}  // namespace restirpg
