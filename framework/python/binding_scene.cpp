// Scenes, graph descriptions and the list of devices.
#include "binding.h"

#include "core/error_kinds.h"
#include "core/paths.h"
#include "gpu/device.h"
#include "graph/graph.h"
#include "graph/plugins.h"
#include "scene/gltf.h"

#include <memory>
#include <optional>

namespace restirpg::python {
namespace {

namespace fs = std::filesystem;

constexpr const char* LOAD_SCENE = R"(Read a glTF 2.0 scene (.gltf or .glb).

camera: number of the scene's camera, from 0. environment: an equirectangular .exr or .hdr file, or a constant radiance
"r,g,b" in W/sr/m^2, in place of the scene's own. allow_outside: let the scene read files that lie outside of its own
folder. Raises Error for files that are missing, damaged or unsupported.)";

constexpr const char* LOAD_GRAPH = R"(Read a graph file (.py, evaluated by a Python of its own, or .json).

Only its shape is checked here; Renderer checks it against the passes.)";

/// (first key, last key, jump) of each channel: a list of tuples.
py::list animationKeys(const Scene& scene)
{
    py::list result;
    for (const AnimationChannel& channel : scene.channels) {
        const bool jump = channel.interpolation == AnimationChannel::Interpolation::step && channel.times.size() <= 2;
        if (!channel.times.empty())
            result.append(py::make_tuple(channel.times.front(), channel.times.back(), jump));
    }
    return result;
}

std::vector<fs::path> codePaths()
{
    std::vector<fs::path> paths = {libraryFolder() / "librestirpg.so", shaderFolder()};
    const auto passes = Plugins().code();
    paths.insert(paths.end(), passes.begin(), passes.end());
    return paths;
}

/// As load_scene was given it; none: the scene has its own.
std::optional<std::string> environmentOf(const Scene& scene)
{
    if (!scene.givenEnvironment)
        return {};
    const auto& [name, hash] = *scene.givenEnvironment;
    return hash.empty() ? name : scene.files.back().string();
}

std::vector<std::string> nodeNames(const Scene& scene)
{
    std::vector<std::string> names;
    for (const Node& node : scene.nodes)
        names.push_back(node.name);
    return names;
}

py::list devices()
{
    py::list result;
    for (const DeviceDescription& device : listDevices()) {
        py::dict entry;
        entry["name"] = device.name;
        entry["driver"] = device.driver;
        entry["type"] = device.type;
        entry["ray_query"] = device.rayQuery;
        entry["missing"] = device.missing;
        result.append(entry);
    }
    return result;
}

}  // namespace

void bindScene(py::module_& module)
{
    using namespace py::literals;
    py::class_<Scene, std::shared_ptr<Scene>>(module, "Scene", "A scene on the host, from load_scene.")
        .def_readonly("file", &Scene::file, "Path it was read from.")
        .def_readonly("hash", &Scene::hash, "Content hash of the file and all it refers to, 16 hexadecimal digits.")
        .def_property_readonly(
            "environment", &environmentOf,
            "What load_scene was given in place of the scene's own environment: a file, or \"r,g,b\"; else None.")
        .def_property_readonly(
            "environment_hash",
            [](const Scene& scene) { return scene.givenEnvironment.value_or(GivenEnvironment{}).hash; },
            "Content hash of that file, which `hash` does not cover; empty: there is none.")
        .def_readonly("bounce_cap", &Scene::bounceCap, "The scene's own bounce cap, or None.")
        .def_readonly("duration", &Scene::duration, "End of the last animation key, s.")
        .def_property_readonly(
            "animation_keys", &animationKeys,
            "Of each animation channel: (time of its first key, of its last, s; whether it jumps from one "
            "value to another at its last key and moves at no other time).")
        .def_property_readonly("triangles", &Scene::instancedTriangleCount,
                               "Number of triangles, each instance counted.")
        .def_property_readonly(
            "cameras", [](const Scene& scene) { return scene.cameras.size(); }, "Number of cameras.")
        .def_property_readonly("nodes", &nodeNames, "Names of the nodes, for Renderer.move_node.")
        .def("__repr__", [](const Scene& scene) {
            return fmt::format("<restirpg.Scene {}: {} triangles>", escaped(scene.file.string()),
                               scene.instancedTriangleCount());
        });
    module.def(
        "load_scene",
        [](const fs::path& file, uint32_t camera, const std::optional<std::string>& environment, bool allowOutside) {
            return std::make_shared<Scene>(loadScene(file, environment, camera, allowOutside));
        },
        LOAD_SCENE, "file"_a, "camera"_a = 0, "environment"_a = py::none(), "allow_outside"_a = false,
        py::call_guard<py::gil_scoped_release>());

    py::class_<GraphDescription>(module, "GraphDescription", "A graph as data, from load_graph.")
        .def_property_readonly(
            "description", [](const GraphDescription& graph) { return toPython(graph.json); },
            "The description as a dictionary; restirpg.graph documents the schema.")
        .def("__repr__", [](const GraphDescription& graph) {
            return fmt::format("<restirpg.GraphDescription {}>", graph.json.value("name", "without a name"));
        });
    module.def(
        "load_graph",
        [](const fs::path& file) {
            return GraphDescription{readGraphFile(file), file};
        },
        LOAD_GRAPH, "file"_a, py::call_guard<py::gil_scoped_release>());

    module.def(
        "code_paths", &codePaths,
        "Files and folders of code that pictures depend on, where this process takes them from: the framework's "
        "library, "
        "its shaders (RESTIRPG_SHADERS), and of each pass (RESTIRPG_PLUGIN_PATH) the library and its kernels' folder.");

    module.def("devices", &devices,
               "Every Vulkan device: a list of {name, driver, type, ray_query, missing}. A device is usable when "
               "`missing`, the "
               "required features it lacks, is empty.");
}

}  // namespace restirpg::python
