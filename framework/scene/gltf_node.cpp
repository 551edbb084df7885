// The node hierarchy of the default scene, and what hangs on it: instances, cameras, lights, animation.
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>

namespace restirpg::gltf {

namespace {

/// A node scaled to zero is hidden; this hides it as well and keeps its matrix invertible between keys.
constexpr float SMALLEST_SCALE = 1e-6f;

class NodeReader {
public:
    NodeReader(const File& file, Scene& scene)
        : file_(file), scene_(scene), sceneNode_(file.model.nodes.size(), INVALID_INDEX) {}

    void read()
    {
        addHierarchy();
        addCameras();
        addLights();
        for (const auto& animation : file_.model.animations)
            addAnimation(animation);
        addInstances();
    }

private:
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
            scene_.nodes.push_back(makeNode(source, index, parent));
            push(source.children, int(scene_.nodes.size() - 1));
        }
    }

    Node makeNode(const tinygltf::Node& source, int index, int parent) const
    {
        Node node;
        node.name = source.name;
        node.parent = parent;
        node.gltfIndex = uint32_t(index);
        const auto vector = [](const std::vector<double>& v) { return glm::vec3(v[0], v[1], v[2]); };
        if (!source.translation.empty())
            node.translation = vector(source.translation);
        if (!source.scale.empty())
            node.scale = vector(source.scale);
        if (!source.rotation.empty()) {
            const auto& r = source.rotation;
            node.rotation = glm::quat(float(r[3]), float(r[0]), float(r[1]), float(r[2]));
            if (!(glm::length(node.rotation) > 0))
                fail("{}: {}: rotation is zero; export it again", file_.name(),
                     label("node", size_t(index), source.name));
            node.rotation = glm::normalize(node.rotation);
        }
        if (!source.matrix.empty()) {
            glm::mat4 matrix;
            for (int i = 0; i < 16; ++i)
                matrix[i / 4][i % 4] = float(source.matrix[size_t(i)]);
            node.matrix = matrix;
        }
        return node;
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
            if (!(yfov > 0 && yfov < 3.14159f))
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
            light.innerCone = float(source.spot.innerConeAngle);
            light.outerCone = float(source.spot.outerConeAngle);
            if (light.type == LIGHT_SPOT &&
                !(light.innerCone >= 0 && light.innerCone < light.outerCone && light.outerCone < 1.5708f))
                fail("{}: {}: cone angles {} and {} must satisfy 0 <= inner < outer <= pi/2; set them anew",
                     file_.name(), label("light", index, source.name), light.innerCone, light.outerCone);
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

    void addAnimation(const tinygltf::Animation& animation)
    {
        const auto place = label("animation", size_t(&animation - file_.model.animations.data()), animation.name);
        for (size_t i = 0; i < animation.channels.size(); ++i) {
            const auto& source = animation.channels[i];
            if (source.target_node < 0 || sceneNode_[size_t(source.target_node)] == INVALID_INDEX)
                continue;
            const uint32_t node = sceneNode_[size_t(source.target_node)];
            if (source.target_path == "weights" || scene_.nodes[node].matrix) {
                warn("{}: {}: a channel that moves {} is ignored", file_.name(), place,
                     source.target_path == "weights" ? "morph weights" : "a node with a matrix");
                continue;
            }
            if (size_t(source.sampler) >= animation.samplers.size())
                fail("{}: {}: channel {} has sampler {} of {}; export it again", file_.name(), place, i, source.sampler,
                     animation.samplers.size());
            addChannel(source, animation.samplers[size_t(source.sampler)], node,
                       fmt::format("{} channel {}", place, i));
        }
    }

    void addChannel(const tinygltf::AnimationChannel& source, const tinygltf::AnimationSampler& sampler, uint32_t node,
                    const std::string& place)
    {
        AnimationChannel channel;
        channel.node = node;
        channel.path = path(source.target_path, place);
        channel.interpolation = interpolation(sampler.interpolation, place);
        channel.times = readFloats(file_, sampler.input, place + " times", {TINYGLTF_TYPE_SCALAR});
        if (channel.times.empty() || !std::is_sorted(channel.times.begin(), channel.times.end()))
            fail("{}: {}: key times must ascend; export it again", file_.name(), place);
        const bool rotates = channel.path == AnimationChannel::Path::rotation;
        const auto values =
            readFloats(file_, sampler.output, place + " values", {rotates ? TINYGLTF_TYPE_VEC4 : TINYGLTF_TYPE_VEC3});
        const size_t components = rotates ? 4 : 3;
        const bool cubic = channel.interpolation == AnimationChannel::Interpolation::cubicSpline;
        if (values.size() / components != channel.times.size() * (cubic ? 3 : 1))
            fail("{}: {}: {} values for {} keys; export it again", file_.name(), place, values.size() / components,
                 channel.times.size());
        for (size_t i = 0; i < values.size(); i += components)
            channel.values.emplace_back(values[i], values[i + 1], values[i + 2], rotates ? values[i + 3] : 0.0f);
        if (channel.path == AnimationChannel::Path::scale)
            for (auto& value : channel.values)
                for (int c = 0; c < 3 && !cubic; ++c)
                    value[c] = std::copysign(std::max(std::abs(value[c]), SMALLEST_SCALE), value[c]);
        scene_.duration = std::max(scene_.duration, channel.times.back());
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

    void addInstances()
    {
        const auto pose = poseNodes(scene_, 0);
        for (size_t i = 0; i < scene_.nodes.size(); ++i) {
            const auto& source = file_.model.nodes[scene_.nodes[i].gltfIndex];
            if (source.skin >= 0)
                warn("{}: skins are not animated; the rest pose is shown", file_.name());
            if (source.mesh < 0 || scene_.meshes[size_t(source.mesh)].triangleCount == 0)
                continue;
            const auto inverse = glm::inverse(pose[i]);
            if (!std::isfinite(glm::dot(inverse[0] + inverse[1] + inverse[2] + inverse[3], glm::vec4(1)))) {
                warn("{}: {}: its matrix has no inverse; its mesh is left out", file_.name(),
                     label("node", scene_.nodes[i].gltfIndex, source.name));
                continue;
            }
            scene_.instances.push_back({uint32_t(source.mesh), uint32_t(i)});
        }
    }

    const File& file_;
    Scene& scene_;
    std::vector<uint32_t> sceneNode_;  ///< of each glTF node, INVALID_INDEX: not in the default scene
};

}  // namespace

void readNodes(const File& file, Scene& scene)
{
    NodeReader(file, scene).read();
}

}  // namespace restirpg::gltf
