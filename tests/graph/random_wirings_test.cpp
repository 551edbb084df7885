// A graph that the wiring check accepts renders. Random wirings of every pass, right and wrong, with random knobs: each
// is refused in located lines before anything is built, or renders three frames without a validation message.
//
// RESTIRPG_WIRINGS=500 tries as many. The wiring that is being tried lies in random_wiring.json of the build
// folder: a graph file for `restirpg render`, should the program end here.
#include "../scene/gltf_builder.h"
#include "image/image.h"
#include "render/executor.h"
#include "render/scene_gpu.h"

#include <gtest/gtest.h>

#include <fstream>
#include <random>

namespace restirpg {
namespace {

using nlohmann::json;

constexpr uint32_t SIZE = 16;  // pixels
constexpr const char* FILE_NAME = "random.json";

/// A floor, a mirror and a pane of glass under a square light.
Scene smallScene()
{
    GltfBuilder builder;
    const auto place = [&](const json& material, const json& node) {
        auto primitive = addSquare(builder);
        primitive["material"] = builder.addMaterial(material);
        json placed = node;
        placed["mesh"] = builder.addMesh(json::array({primitive}));
        builder.addNode(placed);
    };
    place({{"pbrMetallicRoughness", {{"metallicFactor", 0}}}}, {{"scale", {4, 4, 1}}, {"translation", {-2, -2, -1}}});
    place({{"emissiveFactor", {1, 1, 1}}}, {{"translation", {-1, 1, 0}}});
    place({{"pbrMetallicRoughness", {{"roughnessFactor", 0.2}}}}, {{"translation", {1, 0, -0.5}}});
    place({{"extensions", {{"KHR_materials_transmission", {{"transmissionFactor", 1}}}}}, {"doubleSided", true}},
          {{"translation", {-0.5, -1, 0.5}}});
    builder.json["extensionsUsed"] = {"KHR_materials_transmission"};
    return load(builder);
}

/// What a pass type declares, with the pass that declared it: sizes and knobs point into it.
struct Type {
    std::string name;
    std::unique_ptr<Pass> pass;
    Interface interface;
};

class Wirings {
public:
    Wirings(const Plugins& plugins, std::string reference) : reference_(std::move(reference))
    {
        for (const auto& name : plugins.names()) {
            auto& type = types_.emplace_back();
            type.name = name;
            std::tie(type.pass, type.interface) = instantiate(*plugins.find(name)->entry);
        }
    }

    /// A description: of the seed alone.
    json make(uint32_t seed)
    {
        random_.seed(seed);
        bounces_ = below(9);
        std::vector<const Type*> chosen{find("GBuffer")};
        for (size_t i = 0, drawn = 2 + below(7); i < drawn; ++i)
            chosen.push_back(&types_[below(types_.size())]);
        if (chance(30))
            addMakers(chosen);
        const size_t count = chosen.size();
        json graph = {{"name", "Random"}, {"file", FILE_NAME}, {"passes", json::array()}, {"outputs", json::array()}};
        for (size_t i = 0; i < count; ++i)
            graph["passes"].push_back({{"name", nameOf(i)},
                                       {"type", chosen[i]->name},
                                       {"file", FILE_NAME},
                                       {"line", i + 1},
                                       {"inputs", inputsOf(chosen, i)},
                                       {"knobs", knobsOf(*chosen[i])}});
        for (size_t i = 0, outputs = 1 + below(3); i < outputs; ++i) {
            const size_t pass = count - 1 - below(std::min<size_t>(count, 3));
            const auto& ports = chosen[pass]->interface.outputs();
            graph["outputs"].push_back({{"name", "o" + std::to_string(i)},
                                        {"pass", nameOf(pass)},
                                        {"output", ports[below(ports.size())].name},
                                        {"file", FILE_NAME},
                                        {"line", count + i + 1}});
        }
        return graph;
    }

private:
    static std::string nameOf(size_t pass) { return "p" + std::to_string(pass); }
    size_t below(size_t bound) { return random_() % bound; }
    bool chance(uint32_t percent) { return below(100) < percent; }
    const Type* find(const std::string& name) const
    {
        return &*std::find_if(types_.begin(), types_.end(), [&](const Type& type) { return type.name == name; });
    }

    /// Passes that make what the chosen ones cannot do without, before them.
    void addMakers(std::vector<const Type*>& chosen)
    {
        const auto makes = [](const Type* type, const InputPort& input) {
            const auto& outputs = type->interface.outputs();
            return std::any_of(outputs.begin(), outputs.end(),
                               [&](const OutputPort& output) { return input.type.takes(output.type); });
        };
        for (size_t i = 0; i < chosen.size(); ++i)
            for (const auto& input : chosen[i]->interface.inputs()) {
                const auto made = [&](const Type* type) { return makes(type, input); };
                if (input.optional || std::any_of(chosen.begin(), chosen.end(), made))
                    continue;
                std::vector<const Type*> makers;
                for (const auto& type : types_)
                    if (makes(&type, input))
                        makers.push_back(&type);
                if (makers.empty())
                    continue;
                chosen.insert(chosen.begin() + ptrdiff_t(i), makers[below(makers.size())]);
                --i;  // what the maker itself needs comes next
                break;
            }
    }

    json inputsOf(const std::vector<const Type*>& chosen, size_t pass)
    {
        json inputs = json::object();
        const bool whole = chance(60);  // groups of inputs as they belong together: all
        for (const auto& input : chosen[pass]->interface.inputs()) {
            if (input.optional && !(whole ? chance(75) : chance(50)))
                continue;
            // Now and then what does not fit.
            const bool fitting = !chance(2);
            std::vector<json> sources;
            for (size_t source = 0; source < chosen.size(); ++source)
                for (const auto& output : chosen[source]->interface.outputs())
                    for (const bool delayed : {false, true}) {
                        const bool fits = input.type.takes(output.type) && (delayed || source < pass) &&
                                          input.moment != (delayed ? Moment::thisFrame : Moment::frameBefore);
                        if (fits || !fitting)
                            sources.push_back(
                                {{"pass", nameOf(source)}, {"output", output.name}, {"delayed", delayed}});
                    }
            if (!sources.empty())
                inputs[input.name] = sources[below(sources.size())];
        }
        return inputs;
    }

    json knobsOf(const Type& type)
    {
        json knobs = json::object();
        for (const auto& knob : type.interface.knobs()) {
            if (knob.name == "bounces")
                knobs["bounces"] = chance(90) ? bounces_ : below(20);
            else if (knob.name == "reference")
                knobs["reference"] = reference_;
            else if (knob.name == "cells")
                knobs["cells"] = chance(90) ? 4096 : 1024 + below(8192);
            else if (chance(15))
                knobs[knob.name] = valueOf(knob);
        }
        return knobs;
    }

    json valueOf(const Knob& knob)
    {
        if (knob.typeName() == "bool")
            return chance(50);
        if (knob.typeName() == "choice")
            return knob.choices[below(knob.choices.size())];
        if (knob.typeName() == "string")
            return "";
        const double shares[] = {0, 1, 0.1, double(below(1000)) / 999};
        const double value = knob.minimum + (knob.maximum - knob.minimum) * shares[below(4)];
        return knob.typeName() == "float" ? json(value) : json(int64_t(value));
    }

    std::string reference_;
    std::vector<Type> types_;
    std::mt19937 random_;
    uint32_t bounces_ = 0;
};

class RandomWirings : public testing::Test {
protected:
    RandomWirings()
        : device_({.device = "", .backend = "", .validation = true}), pose_(poseNodes(scene_, 0)),
          sceneGpu_(device_, scene_, pose_)
    {
    }

    void render(std::unique_ptr<Graph> graph)
    {
        Executor executor(device_, std::move(graph), SIZE, SIZE, {});
        FrameConstants constants{};
        constants.scene = sceneGpu_.table();
        constants.camera = makeCamera(scene_.cameras[0], pose_[scene_.cameras[0].node], 1);
        constants.previousCamera = constants.camera;
        constants.size = {SIZE, SIZE};
        for (int frame = 0; frame < 3; ++frame)
            executor.run(constants, sceneGpu_.bindings());
    }

    const Scene scene_ = smallScene();
    Device device_;
    const std::vector<glm::mat4> pose_;
    SceneGpu sceneGpu_;
};

TEST_F(RandomWirings, AreRefusedInLocatedLinesOrRender)
{
    const Plugins plugins;
    const auto reference = scratch() / "reference.exr";
    writeExr(reference, {{"", Image{SIZE, SIZE, 3, std::vector<float>(SIZE * SIZE * 3, 0.5f)}}}, PixelType::full, {});
    Wirings wirings(plugins, reference.string());
    const char* asked = std::getenv("RESTIRPG_WIRINGS");
    const uint32_t count = asked ? uint32_t(std::stoul(asked)) : 40;
    uint32_t refused = 0, rendered = 0;
    for (uint32_t seed = 0; seed < count; ++seed) {
        SCOPED_TRACE(fmt::format("seed {}", seed));
        const json description = wirings.make(seed);
        std::unique_ptr<Graph> graph;
        try {
            graph = std::make_unique<Graph>(description, plugins);
        } catch (const Error& error) {
            EXPECT_TRUE(std::string_view(error.what()).starts_with("random.json:")) << error.what();
            ++refused;
            continue;
        }
        std::ofstream(RESTIRPG_BUILD "/random_wiring.json") << description.dump(1);
        try {
            render(std::move(graph));
        } catch (const std::exception& error) {
            ADD_FAILURE() << "accepted, then: " << error.what() << "\n" << description.dump(1);
        }
        ++rendered;
    }
    RecordProperty("refused", int(refused));
    EXPECT_GT(refused, count / 10);
    EXPECT_GT(rendered, count / 20);
}

}  // namespace
}  // namespace restirpg
