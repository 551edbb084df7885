// What the nodes of the default scene show: meshes, with their morph weights and skins applied.
#include "core/memory.h"
#include "scene/gltf_primitive.h"

#include <algorithm>
#include <map>
#include <utility>

namespace restirpg::gltf {

namespace {

/// More than fits any GPU.
constexpr uint64_t MOST_TRIANGLES = uint64_t(1) << 27;
/// With every instance counted: bounds and light powers go over each.
constexpr uint64_t MOST_INSTANCED_TRIANGLES = uint64_t(1) << 29;

/// Bytes on the host and on the device together, the builders' working space included.
constexpr uint64_t BYTES_PER_VERTEX = 180, BYTES_PER_TRIANGLE = 260, BYTES_PER_LIGHT = 240, BYTES_PER_INSTANCE = 1000;

Shape shapeOf(const File& file, size_t node)
{
    const auto& source = file.model.nodes[node];
    const auto& mesh = file.model.meshes[size_t(source.mesh)];
    Shape shape;
    shape.mesh = source.mesh;
    const bool morphs = std::any_of(mesh.primitives.begin(), mesh.primitives.end(),
                                    [](const auto& primitive) { return !primitive.targets.empty(); });
    if (morphs)
        shape.weights = source.weights.empty() ? mesh.weights : source.weights;
    while (!shape.weights.empty() && shape.weights.back() == 0)
        shape.weights.pop_back();
    shape.skin = source.skin;
    shape.node = source.skin < 0 ? -1 : int(node);
    return shape;
}

/// What a mesh asks for, told from the accessors' counts.
struct Cost {
    uint64_t vertices = 0;
    uint64_t triangles = 0;
    uint64_t emissive = 0;  ///< triangles that emit
};

Cost costOf(const File& file, const Scene& scene, int mesh)
{
    Cost cost;
    const auto& source = file.model.meshes[size_t(mesh)];
    for (const auto& primitive : source.primitives) {
        if (!hasTriangles(file, primitive))
            continue;
        const auto count = [&](int accessor, const char* what) {
            checkAccessor(file, accessor, fmt::format("{} {}", label("mesh", size_t(mesh), source.name), what));
            return uint64_t(file.model.accessors[size_t(accessor)].count);
        };
        const uint64_t vertices = count(primitive.attributes.at("POSITION"), "POSITION");
        const uint64_t corners = primitive.indices < 0 ? vertices : count(primitive.indices, "indices");
        const uint64_t triangles = primitive.mode == TINYGLTF_MODE_TRIANGLES ? corners / 3 : corners;
        cost.triangles += triangles;
        cost.vertices += primitive.attributes.contains("NORMAL") ? vertices : vertices + 3 * triangles;
        if (primitive.material >= 0 && scene.materials[size_t(primitive.material)].flags & MATERIAL_EMISSIVE)
            cost.emissive += triangles;
    }
    return cost;
}

class InstanceReader {
public:
    InstanceReader(const File& file, Scene& scene) : file_(file), scene_(scene), count_(scene.nodes.size())
    {
        for (size_t i = 0; i < count_; ++i)
            if (const auto node = scene.nodes[i].gltfIndex; file.model.nodes[node].mesh >= 0)
                shapes_[i] = shapeOf(file, node);
    }

    void read()
    {
        checkCost();
        for (const auto& [node, shape] : shapes_)
            shape.skin < 0 ? addInstance(meshOf(shape), uint32_t(node)) : addSkinned(shape, node);
        if (movesSkins())
            warnOfDeformation(file_);
    }

private:
    void checkCost() const
    {
        std::map<int, Cost> costs;
        std::map<Shape, bool> seen;
        uint64_t triangles = 0, instanced = 0, bytes = 0;
        for (const auto& [node, shape] : shapes_) {
            if (!costs.contains(shape.mesh))
                costs[shape.mesh] = costOf(file_, scene_, shape.mesh);
            const auto& cost = costs[shape.mesh];
            instanced += cost.triangles;
            bytes += BYTES_PER_INSTANCE + BYTES_PER_LIGHT * cost.emissive;
            if (!std::exchange(seen[shape], true)) {
                triangles += cost.triangles;
                bytes += BYTES_PER_VERTEX * cost.vertices + BYTES_PER_TRIANGLE * cost.triangles;
            }
        }
        if (triangles > MOST_TRIANGLES)
            fail("{}: {} triangles are more than {}; simplify the scene", file_.name(), triangles, MOST_TRIANGLES);
        if (instanced > MOST_INSTANCED_TRIANGLES)
            fail("{}: {} triangles, every instance counted, are more than {}; show fewer instances", file_.name(),
                 instanced, MOST_INSTANCED_TRIANGLES);
        checkMemory(file_.name(), fmt::format("the geometry of {} triangles", triangles), bytes, "simplify the scene");
    }

    /// The scene's mesh of a shape without a skin, made on first use.
    uint32_t meshOf(const Shape& shape)
    {
        if (const auto found = meshes_.find(shape); found != meshes_.end())
            return found->second;
        return meshes_[shape] = addMesh(file_, shape, nullptr, scene_);
    }

    void addInstance(uint32_t mesh, uint32_t node)
    {
        if (scene_.meshes[mesh].triangleCount > 0)
            scene_.instances.push_back({mesh, node});
    }

    /// A skinned mesh stands where its joints are, in the world; its node's matrix does not act [glTF 2.0, 3.7.3.3].
    void addSkinned(const Shape& shape, size_t node)
    {
        if (rest_.empty())
            rest_ = restPose(file_);
        const auto skin = readSkin(file_, shape, rest_);
        const uint32_t mesh = addMesh(file_, shape, &skin, scene_);
        if (scene_.meshes[mesh].triangleCount == 0)
            return;
        Node world;
        world.name = scene_.nodes[node].name + " (skinned)";
        world.gltfIndex = scene_.nodes[node].gltfIndex;
        world.translation = skin.place;
        scene_.nodes.push_back(world);
        scene_.instances.push_back({mesh, uint32_t(scene_.nodes.size() - 1)});
    }

    /// Does an animation move a joint of a skin that is shown?
    bool movesSkins() const
    {
        const auto animated = animatedNodes(scene_);
        std::vector<bool> moves(file_.model.nodes.size());
        for (size_t i = 0; i < count_; ++i)
            moves[scene_.nodes[i].gltfIndex] = animated[i];
        return std::any_of(shapes_.begin(), shapes_.end(), [&](const auto& entry) {
            const int skin = entry.second.skin;
            if (skin < 0)
                return false;
            const auto& joints = file_.model.skins[size_t(skin)].joints;
            return std::any_of(joints.begin(), joints.end(), [&](int joint) { return moves[size_t(joint)]; });
        });
    }

    const File& file_;
    Scene& scene_;
    size_t count_;  ///< of the file's nodes in the scene
    std::map<size_t, Shape> shapes_;  ///< of the scene's nodes that show something
    std::map<Shape, uint32_t> meshes_;
    std::vector<glm::dmat4> rest_;
};

}  // namespace

void warnOfDeformation(const File& file)
{
    warn("{}: the animation of skins and morph targets is not shown; they stay in their rest pose", file.name());
}

void readInstances(const File& file, Scene& scene)
{
    InstanceReader(file, scene).read();
    clearNeedlessMasks(scene);
}

}  // namespace restirpg::gltf
