#include "scene/gltf.h"

#include "core/error_kinds.h"
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>

namespace restirpg {

namespace {

using namespace gltf;

/// A camera of 40 degrees that looks from the upper right; the bounding sphere almost fills the picture.
void addDefaultCamera(Scene& scene, const Bounds& bounds)
{
    constexpr float YFOV = 0.6981317f;  // 40 degrees
    const auto center = 0.5f * (bounds.lower + bounds.upper);
    const float radius = std::max(0.5f * glm::length(bounds.upper - bounds.lower), 1e-3f);
    const auto backward = glm::normalize(glm::vec3(0.35f, 0.25f, 1.0f));
    const auto right = glm::normalize(glm::cross(glm::vec3(0, 1, 0), backward));
    const auto eye = center + backward * (0.9f * radius / std::sin(YFOV / 2));
    Node node;
    node.name = "default camera";
    node.gltfIndex = INVALID_INDEX;
    node.matrix = glm::mat4(glm::vec4(right, 0), glm::vec4(glm::cross(backward, right), 0), glm::vec4(backward, 0),
                            glm::vec4(eye, 1));
    scene.nodes.push_back(node);
    scene.cameras.push_back({node.name, uint32_t(scene.nodes.size() - 1), YFOV});
}

/// One that is switched off, by a strength of 0, is an emitter.
bool isEmitter(const tinygltf::Material& material)
{
    const auto& factor = material.emissiveFactor;
    return std::any_of(factor.begin(), factor.end(), [](double value) { return value > 0; }) &&
           !extension(material.extensions, "KHR_materials_unlit");
}

/// Whether the scene has a light, even one that is switched off: an edit may switch it on.
bool namesLight(const File& file, const Scene& scene)
{
    if (scene.environment || !scene.punctualLights.empty())
        return true;
    const auto& materials = file.model.materials;
    for (const auto& instance : scene.instances) {
        const auto& mesh = scene.meshes[instance.mesh];
        for (uint32_t t = 0; t < mesh.triangleCount; ++t) {
            const uint32_t material = scene.materialOfTriangle[mesh.firstTriangle + t];
            if (material < materials.size() && isEmitter(materials[material]))
                return true;
        }
    }
    return false;
}

/// The environment that asset.extras.restirpg describes. Its file's bytes join the hash.
void readEnvironment(const File& file, const tinygltf::Value& settings, Scene& scene, uint64_t& hash)
{
    const auto* source = member(settings, "environment");
    if (!source)
        return;
    if (source->IsString()) {
        const auto path = file.resources.resolve(source->Get<std::string>(), "asset.extras.restirpg.environment");
        scene.environment = loadEnvironment(path.string());
        const auto bytes = readBytes(path);
        hash = hashBytes(bytes.data(), bytes.size(), hash);
        scene.files.push_back(path);
    } else if (source->ArrayLen() == 3) {
        scene.environment.emplace();
        scene.environment->radiance = glm::max(color(settings, "environment", glm::vec3(0)), 0.0f);
    } else {
        fail("{}: asset.extras.restirpg.environment: must be a file name or three numbers; mend the extras",
             file.name());
    }
    scene.environment->radiance *= std::max(number(settings, "strength", 1), 0.0f);
    scene.environment->rotation = glm::radians(number(settings, "rotation", 0));
    if (!std::isfinite(glm::dot(scene.environment->radiance, glm::vec3(1))) ||
        !std::isfinite(scene.environment->rotation))
        fail("{}: asset.extras.restirpg: environment, strength or rotation is not finite; mend the extras",
             file.name());
}

void readExtras(const File& file, Scene& scene, uint64_t& hash)
{
    const auto* settings = member(file.model.asset.extras, "restirpg");
    if (!settings)
        return;
    readEnvironment(file, *settings, scene, hash);
    if (const auto* bounces = member(*settings, "bounces")) {
        if (!bounces->IsInt() || bounces->GetNumberAsInt() < 0)
            fail("{}: asset.extras.restirpg.bounces: must be an integer of at least 0; mend the extras", file.name());
        scene.bounceCap = uint32_t(bounces->GetNumberAsInt());
    }
}

Scene convert(const std::filesystem::path& path, bool allowOutside)
{
    const auto file = readFile(path, allowOutside);
    Scene scene;
    scene.file = path;
    scene.files = {path};
    scene.files.insert(scene.files.end(), file.external.begin(), file.external.end());
    readMaterials(file, scene);
    readNodes(file, scene);
    readInstances(file, scene);
    if (scene.instances.empty())
        fail("{}: the default scene has no triangles; add a mesh", file.name());
    uint64_t hash = file.hash;
    readExtras(file, scene, hash);
    scene.hash = fmt::format("{:016x}", hash);

    const auto bounds = deriveFromNodes(scene);
    if (scene.cameras.empty()) {
        warn("{}: no perspective camera; one that frames the scene is added", file.name());
        addDefaultCamera(scene, bounds);
    }
    if (!namesLight(file, scene)) {
        warn("{}: no light; a white environment of radiance 1 is added", file.name());
        scene.environment.emplace();
        scene.environment->radiance = glm::vec3(1);
    }
    return scene;
}

}  // namespace

Scene loadGltf(const std::filesystem::path& file, bool allowOutside)
{
    try {
        return convert(file, allowOutside);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        fail("{}: does not fit the memory; simplify the scene", file.string());
    } catch (const std::exception& error) {
        fail("{}: damaged: {}; export it again", file.string(), printable(error.what()));
    }
}

Scene loadScene(const std::filesystem::path& file, const std::optional<std::string>& environment, uint32_t camera,
                bool allowOutside)
{
    Scene scene = loadGltf(file, allowOutside);
    if (environment)
        replaceEnvironment(scene, *environment);
    if (camera >= scene.cameras.size())
        failAs<WrongValue>("{}: there is no camera {}; the scene has {}, counted from 0", file.string(), camera,
                           scene.cameras.size());
    scene.camera = camera;
    return scene;
}

}  // namespace restirpg
