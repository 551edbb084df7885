// The node hierarchy of the default scene, and what hangs on it: cameras, lights, animation.
#include "core/memory.h"
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>
#include <utility>

namespace restirpg::gltf {

namespace {

class NodeReader {
public:
    NodeReader(const File& file, Scene& scene)
        : file_(file), scene_(scene), sceneNode_(file.model.nodes.size(), INVALID_INDEX)
    {
    }

    void read()
    {
        addHierarchy();
        addCameras();
        addLights();
        for (const auto& animation : file_.model.animations)
            chooseChannels(animation);
        checkKeys();
        for (const auto& [target, played] : played_)
            addChannel(target, played);
        for (const auto& channel : scene_.channels)
            scene_.duration = std::max(scene_.duration, channel.times.back());
    }

private:
    /// What a channel moves: a node, and what of it.
    using Target = std::pair<uint32_t, AnimationChannel::Path>;

    struct Played {
        const tinygltf::AnimationSampler* sampler;
        std::string place;  ///< for messages
    };

    /// Roots of the default scene; without any scene, the nodes that are nobody's child.
    std::vector<int> roots() const
    {
        const auto& model = file_.model;
        if (!model.scenes.empty())
            return model.scenes[size_t(std::max(model.defaultScene, 0))].nodes;
        std::vector<bool> child(model.nodes.size());
        for (const auto& node : model.nodes)
            for (int c : node.children)
                child[size_t(c)] = true;
        std::vector<int> result;
        for (size_t i = 0; i < child.size(); ++i)
            if (!child[i])
                result.push_back(int(i));
        return result;
    }

    /// Depth first with an explicit stack: a file may nest deeper than the program's.
    void addHierarchy()
    {
        struct Pending {
            int node, parent;
        };
        std::vector<Pending> stack;
        const auto push = [&](const std::vector<int>& nodes, int parent) {
            for (auto node = nodes.rbegin(); node != nodes.rend(); ++node)
                stack.push_back({*node, parent});
        };
        push(roots(), -1);
        while (!stack.empty()) {
            const auto [index, parent] = stack.back();
            stack.pop_back();
            const auto& source = file_.model.nodes[size_t(index)];
            if (sceneNode_[size_t(index)] != INVALID_INDEX)
                fail("{}: {}: is reached twice (a cycle, or two parents); export it again", file_.name(),
                     label("node", size_t(index), source.name));
            sceneNode_[size_t(index)] = uint32_t(scene_.nodes.size());
            scene_.nodes.push_back(makeNode(file_, size_t(index), parent));
            push(source.children, int(scene_.nodes.size() - 1));
        }
    }

    /// In the order of the file's nodes, which is how other tools number cameras.
    void addCameras()
    {
        for (size_t i = 0; i < file_.model.nodes.size(); ++i) {
            const auto& node = file_.model.nodes[i];
            if (node.camera < 0 || sceneNode_[i] == INVALID_INDEX)
                continue;
            const auto& camera = file_.model.cameras[size_t(node.camera)];
            if (camera.type != "perspective") {
                warn("{}: {} is {}; only perspective cameras are read", file_.name(),
                     label("camera", size_t(node.camera), camera.name), printable(camera.type));
                continue;
            }
            const float yfov = float(camera.perspective.yfov);
            if (!(yfov > 0 && yfov < LARGEST_YFOV))
                fail("{}: {}: yfov {} must lie between 0 and pi; set it anew", file_.name(),
                     label("camera", size_t(node.camera), camera.name), yfov);
            scene_.cameras.push_back({camera.name.empty() ? node.name : camera.name, sceneNode_[i], yfov});
        }
    }

    void addLights()
    {
        for (size_t i = 0; i < file_.model.nodes.size(); ++i) {
            const auto* punctual = extension(file_.model.nodes[i].extensions, "KHR_lights_punctual");
            if (!punctual || sceneNode_[i] == INVALID_INDEX)
                continue;
            const auto index = size_t(number(*punctual, "light", 0));
            const auto& source = file_.model.lights[index];
            PunctualLight light;
            light.node = sceneNode_[i];
            light.type = lightType(source, index);
            light.intensity = glm::vec3(float(std::max(source.intensity, 0.0)));
            for (int c = 0; c < 3 && source.color.size() == 3; ++c)
                light.intensity[c] *= std::max(float(source.color[size_t(c)]), 0.0f);
            if (source.range > 0 && light.type != LIGHT_DIRECTIONAL)
                warn("{}: the range of lights is ignored; their light falls off with the square of the distance",
                     file_.name());
            light.innerCone = float(source.spot.innerConeAngle);
            light.outerCone = float(source.spot.outerConeAngle);
            // As the file has them: in float they may be equal.
            if (const auto [inner, outer] = std::pair(source.spot.innerConeAngle, source.spot.outerConeAngle);
                light.type == LIGHT_SPOT && !(inner >= 0 && inner < outer && outer < 1.5708))
                fail("{}: {}: cone angles {} and {} must satisfy 0 <= inner < outer <= pi/2; set them anew",
                     file_.name(), label("light", index, source.name), inner, outer);
            scene_.punctualLights.push_back(light);
        }
    }

    uint32_t lightType(const tinygltf::Light& source, size_t index) const
    {
        if (source.type == "point")
            return LIGHT_POINT;
        if (source.type == "spot")
            return LIGHT_SPOT;
        if (source.type == "directional")
            return LIGHT_DIRECTIONAL;
        fail("{}: {}: type '{}' is not point, spot or directional; set it anew", file_.name(),
             label("light", index, source.name), printable(source.type));
    }

    /// All animations are played at once; of two channels that move the same, the last in the file is.
    void chooseChannels(const tinygltf::Animation& animation)
    {
        const auto place = label("animation", size_t(&animation - file_.model.animations.data()), animation.name);
        for (size_t i = 0; i < animation.channels.size(); ++i) {
            const auto& source = animation.channels[i];
            if (source.target_node < 0 || sceneNode_[size_t(source.target_node)] == INVALID_INDEX)
                continue;
            const uint32_t node = sceneNode_[size_t(source.target_node)];
            if (source.target_path == "weights") {
                warnOfDeformation(file_);
                continue;
            }
            if (scene_.nodes[node].matrix) {
                warn("{}: {}: a channel that moves a node with a matrix is ignored", file_.name(), place);
                continue;
            }
            if (size_t(source.sampler) >= animation.samplers.size())
                fail("{}: {}: channel {} has sampler {} of {}; export it again", file_.name(), place, i, source.sampler,
                     animation.samplers.size());
            Played played{&animation.samplers[size_t(source.sampler)], fmt::format("{} channel {}", place, i)};
            const Target target{node, path(source.target_path, played.place)};
            if (!played_.insert_or_assign(target, std::move(played)).second)
                warnOfReplaced(node, source.target_path);
        }
    }

    void warnOfReplaced(uint32_t node, const std::string& what)
    {
        if (!std::exchange(warnedOfReplaced_, true))
            warn("{}: {}: two animations or channels move its {}; the last in the file is played", file_.name(),
                 label("node", scene_.nodes[node].gltfIndex, scene_.nodes[node].name), what);
    }

    /// Every channel keeps keys of its own: those that share a sampler may ask for more than the file holds.
    void checkKeys() const
    {
        uint64_t bytes = 0;
        for (const auto& [target, played] : played_)
            for (const auto& [accessor, size] : {std::pair(played.sampler->input, sizeof(float)),
                                                 std::pair(played.sampler->output, sizeof(glm::vec4))}) {
                checkAccessor(file_, accessor, played.place);
                bytes += size * file_.model.accessors[size_t(accessor)].count;
            }
        checkMemory(file_.name(), fmt::format("the animation of {} channels", played_.size()), bytes,
                    "give it fewer keys or channels");
    }

    void addChannel(const Target& target, const Played& played)
    {
        const auto& [sampler, place] = played;
        AnimationChannel channel;
        std::tie(channel.node, channel.path) = target;
        channel.interpolation = interpolation(sampler->interpolation, place);
        channel.times = readFloats(file_, sampler->input, place + " times", {TINYGLTF_TYPE_SCALAR});
        if (channel.times.empty() || !std::is_sorted(channel.times.begin(), channel.times.end()))
            fail("{}: {}: key times must ascend; export it again", file_.name(), place);
        const bool rotates = channel.path == AnimationChannel::Path::rotation;
        const auto values =
            readFloats(file_, sampler->output, place + " values", {rotates ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3});
        const size_t components = rotates ? 4 : 3;
        const bool cubic = channel.interpolation == AnimationChannel::Interpolation::cubicSpline;
        if (values.size() / components != channel.times.size() * (cubic ? 3 : 1))
            fail("{}: {}: {} values for {} keys; export it again", file_.name(), place, values.size() / components,
                 channel.times.size());
        for (size_t i = 0; i < values.size(); i += components)
            channel.values.emplace_back(values[i], values[i + 1], values[i + 2], rotates ? values[i + 3] : 0.0f);
        scene_.channels.push_back(std::move(channel));
    }

    AnimationChannel::Path path(const std::string& name, const std::string& place) const
    {
        if (name == "translation")
            return AnimationChannel::Path::translation;
        if (name == "rotation")
            return AnimationChannel::Path::rotation;
        if (name == "scale")
            return AnimationChannel::Path::scale;
        fail("{}: {}: path '{}' is not translation, rotation or scale; export it again", file_.name(), place,
             printable(name));
    }

    AnimationChannel::Interpolation interpolation(const std::string& name, const std::string& place) const
    {
        if (name == "LINEAR")
            return AnimationChannel::Interpolation::linear;
        if (name == "STEP")
            return AnimationChannel::Interpolation::step;
        if (name == "CUBICSPLINE")
            return AnimationChannel::Interpolation::cubicSpline;
        fail("{}: {}: interpolation '{}' is not LINEAR, STEP or CUBICSPLINE; export it again", file_.name(), place,
             printable(name));
    }

    const File& file_;
    Scene& scene_;
    std::map<Target, Played> played_;
    bool warnedOfReplaced_ = false;
    std::vector<uint32_t> sceneNode_;  ///< of each glTF node, INVALID_INDEX: not in the default scene
};

}  // namespace

Node makeNode(const File& file, size_t index, int parent)
{
    const auto& source = file.model.nodes[index];
    Node node;
    node.name = source.name;
    node.parent = parent;
    node.gltfIndex = uint32_t(index);
    const auto vector = [](const std::vector<double>& v) { return glm::dvec3(v[0], v[1], v[2]); };
    if (!source.translation.empty())
        node.translation = vector(source.translation);
    if (!source.scale.empty())
        node.scale = vector(source.scale);
    if (!source.rotation.empty()) {
        const auto& r = source.rotation;
        node.rotation = glm::dquat(r[3], r[0], r[1], r[2]);
        if (!(glm::length(node.rotation) > 0))
            fail("{}: {}: rotation is zero; export it again", file.name(), label("node", index, source.name));
        node.rotation = glm::normalize(node.rotation);
    }
    if (!source.matrix.empty()) {
        glm::dmat4 matrix;
        for (int i = 0; i < 16; ++i)
            matrix[i / 4][i % 4] = source.matrix[size_t(i)];
        node.matrix = matrix;
    }
    return node;
}

void readNodes(const File& file, Scene& scene)
{
    NodeReader(file, scene).read();
}

}  // namespace restirpg::gltf
