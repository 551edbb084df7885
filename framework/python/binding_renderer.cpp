// The renderer, frame by frame.
#include "binding.h"

#include "core/error_kinds.h"
#include "core/paths.h"
#include "render/bounce_cap.h"
#include "shared_renderer.h"

#include <optional>
#include <variant>

namespace restirpg::python {
namespace {

constexpr const char* RENDERER = R"(A scene, a graph and a device, rendering frame by frame.

scene: from load_scene. graph: from load_graph, or a restirpg.Graph, or its description as a dictionary.
size: (width, height) in pixels. seed: of all random numbers; the same seed gives the same bytes on the same device.
device: number or part of the name as `restirpg devices` lists them; None: the best one. backend: "software", "rayquery"
or None for what suits the device. validation: run under the Vulkan validation layer. fps: frames per second of scene time;
0: the scene stands still. time: of the first frame, s. energy_compensation: rough metal and glass give back the light that
single-scattering GGX loses. outputs: more outputs than the graph has: ports of its passes, as "albedo", "normal" and "depth",
or "pass.port" where several passes have a port of that name. They cost nothing where they are not asked for. window: (x, y,
width, height) in pixels, what alone is rendered of the picture, as it is there; None: all of it. bounces: what the knob
"bounces" of every pass that has it is set to; None: to the scene's own bounce cap, where it has one.

Threads may share a renderer: their calls take turns, those to render between two frames. A forked process cannot use it.
`with Renderer(...) as renderer:` gives back the device's memory at its end.)";

constexpr const char* SEED = R"(Of all random numbers from the next frame on: 0 to 2^32 - 1.

`renderer.seed = s; renderer.cut()` begins a run that has the bytes of a new Renderer with that seed, at a fraction of
its cost. Scene time, camera, nodes and knobs stay as they are: set_time(0) where the scene is animated. Without the
cut, paths of the history would replay numbers of another seed than their own.)";

constexpr const char* MOVE_WINDOW =
    R"(Render another part of the picture, of the same size, from the next frame on; implies cut().

x, y: its first pixel, from the picture's top left.)";

constexpr const char* RENDER =
    R"(Render `frames` more frames. Other Python threads run meanwhile; Ctrl-C ends it between two frames.)";

constexpr const char* OUTPUT =
    R"(An output of the graph after the last frame: float32 (H, W, C), linear, rows from the top.

Raises Error when there is no such output, when it is no image, or before the first frame.)";

constexpr const char* READ_PORT =
    R"(Raw bytes of any port "pass.output" that somebody reads, after the last frame: uint8 (N,).

Raises Error when there is no such port, when nobody reads it, or before the first frame.)";

constexpr const char* CAMERA =
    R"(Where the camera stands: a dictionary of position and target (m), up, and yfov (radians).)";

constexpr const char* SCENE_CAMERAS =
    R"(The scene's cameras in its order, where they stand now: a list of what `camera` has, and name.)";

constexpr const char* MOVE_CAMERA =
    R"(Move the camera from the next frame on; what is None stays. History is kept: cut() forgets it.

position, target: points (3,), m. up: direction (3,). yfov: vertical field of view, radians.)";

constexpr const char* MOVE_NODE =
    R"(Give a node a new local matrix (4, 4) relative to its parent, from the next frame on.

node: its name, or its place in Scene.nodes where the name is empty or several have it. Column vectors: the translation is
the last column.)";

constexpr const char* SAVE =
    R"(Write outputs as one EXR, whose name ends in .exr: the first as R, G, B, the others as layers.

half: half floats. output: write only this one, or only those of a list. The header carries the
graph, its knobs, seed, frames, scene, device and commit, and what of time, camera, environment, moved nodes and edits is not
the default.)";

constexpr const char* RELOAD =
    R"(Read kernels, their headers and the graph anew, and go on with them: what was edited is seen. Implies cut().

graph: one to render by in place of the renderer's own. None: its own; one of load_graph is read anew from its file. Knobs
that were set stay so where the graph has them. Raises Error, located in the graph or the kernel; all is as before then.
Libraries of passes that were compiled anew need a new process.)";

nlohmann::json describe(const py::object& graph)
{
    if (py::isinstance<GraphDescription>(graph))
        return graph.cast<const GraphDescription&>().json;
    // A restirpg.Graph of the package's pure-Python half.
    if (py::hasattr(graph, "description") && PyCallable_Check(graph.attr("description").ptr()))
        return toJson(graph.attr("description")());
    if (py::isinstance<py::dict>(graph))
        return toJson(graph);
    failAs<WrongValue>("{} is not a graph; give what load_graph returns, a restirpg.Graph or a dictionary",
                       py::repr(graph).cast<std::string>());
}

/// The file that load_graph read, or empty.
std::filesystem::path fileOf(const py::object& graph)
{
    return py::isinstance<GraphDescription>(graph) ? graph.cast<const GraphDescription&>().file : "";
}

/// A graph as a renderer of the scene takes it. `outputs`: that it gets besides its own.
std::unique_ptr<Graph> checkedGraph(nlohmann::json description, const Scene& scene,
                                    const std::vector<std::string>& outputs, std::optional<uint32_t> bounces)
{
    auto graph = std::make_unique<Graph>(std::move(description), Plugins());
    for (const auto& name : outputs)
        graph->addOutput(name);
    capBounces(*graph, scene, bounces);
    checkCapped(*graph, scene, bounces);
    return graph;
}

std::unique_ptr<SharedRenderer>
makeRenderer(const std::shared_ptr<Scene>& scene, const py::object& graph, const std::pair<uint32_t, uint32_t>& size,
             uint32_t seed, const std::optional<py::object>& device, const std::optional<std::string>& backend,
             bool validation, float fps, float time, bool energyCompensation, const std::vector<std::string>& outputs,
             const std::optional<std::array<uint32_t, 4>>& window, std::optional<uint32_t> bounces)
{
    RendererOptions options;
    options.width = size.first;
    options.height = size.second;
    if (window)
        options.window = Window{(*window)[0], (*window)[1], (*window)[2], (*window)[3]};
    options.seed = seed;
    options.framesPerSecond = fps;
    options.time = time;
    options.energyCompensation = energyCompensation;
    options.device = {device ? py::str(*device).cast<std::string>() : "", backend.value_or(""), validation};
    auto description = describe(graph);
    auto file = fileOf(graph);
    py::gil_scoped_release release;
    auto renderer =
        std::make_unique<Renderer>(scene, checkedGraph(std::move(description), *scene, outputs, bounces), options);
    return std::make_unique<SharedRenderer>(std::move(renderer), std::move(file), outputs, bounces);
}

void reload(SharedRenderer& shared, const py::object& graph)
{
    const bool same = graph.is_none();
    auto description = same ? nlohmann::json() : describe(graph);
    auto file = same ? std::filesystem::path() : fileOf(graph);
    shared.run([&](Renderer& renderer) {
        if (same) {
            file = shared.graphFile;
            description = file.empty() ? renderer.graph().description() : readGraphFile(file);
        }
        renderer.reload(checkedGraph(std::move(description), renderer.scene(), shared.outputs, shared.bounces));
        shared.graphFile = std::move(file);
    });
}

void render(SharedRenderer& shared, uint32_t frames)
{
    for (uint32_t i = 0; i < frames; ++i) {
        shared.run([](Renderer& renderer) { renderer.render(1); });
        if (PyErr_CheckSignals() != 0)
            throw py::error_already_set();
    }
}

/// As a notebook takes it: None shows nothing.
py::object notebookPng(SharedRenderer& shared)
{
    const auto picture = shared.run([](Renderer& renderer) {
        return renderer.frame() == 0 ? Image() : renderer.output(renderer.outputNames().front());
    });
    return picture.empty() ? py::object(py::none()) : py::bytes(encodePng(picture, {}, "the picture"));
}

py::array_t<uint8_t> readPort(SharedRenderer& shared, const std::string& port)
{
    const auto bytes = shared.run([&](Renderer& renderer) { return renderer.readPort(port); });
    return py::array_t<uint8_t>(py::ssize_t(bytes.size()), bytes.data());
}

using Triple = std::array<double, 3>;

Triple triple(const glm::dvec3& v)
{
    return {v.x, v.y, v.z};
}

py::dict asDict(const CameraPose& pose)
{
    py::dict result;
    result["position"] = triple(pose.position);
    result["target"] = triple(pose.target);
    result["up"] = triple(pose.up);
    result["yfov"] = pose.yfov;
    return result;
}

py::dict camera(SharedRenderer& shared)
{
    return asDict(shared.run([](const Renderer& renderer) { return renderer.camera(); }));
}

py::list sceneCameras(SharedRenderer& shared)
{
    py::list result;
    for (const auto& [name, pose] : shared.run([](const Renderer& renderer) { return renderer.sceneCameras(); })) {
        py::dict entry = asDict(pose);
        entry["name"] = name;
        result.append(entry);
    }
    return result;
}

void moveCamera(SharedRenderer& shared, const std::optional<Triple>& position, const std::optional<Triple>& target,
                const std::optional<Triple>& up, std::optional<float> yfov)
{
    const auto take = [](glm::dvec3& to, const std::optional<Triple>& from) {
        if (from)
            to = {(*from)[0], (*from)[1], (*from)[2]};
    };
    shared.run([&](Renderer& renderer) {
        CameraPose pose = renderer.camera();
        take(pose.position, position);
        take(pose.target, target);
        take(pose.up, up);
        pose.yfov = yfov.value_or(pose.yfov);
        renderer.moveCamera(pose);
    });
}

void moveNode(SharedRenderer& shared, const std::variant<size_t, std::string>& node, const FloatArray& matrix)
{
    if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
        failAs<WrongValue>("a node is moved by a matrix (4, 4), not by an array of shape {}",
                           py::str(py::tuple(matrix.attr("shape"))).cast<std::string>());
    glm::mat4 local;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            local[column][row] = matrix.at(row, column);
    shared.run(
        [&](Renderer& renderer) { std::visit([&](const auto& which) { renderer.moveNode(which, local); }, node); });
}

py::dict deviceInfo(SharedRenderer& shared)
{
    const auto [device, backend] = shared.run(
        [](Renderer& renderer) { return std::pair(renderer.device().description(), renderer.device().backend()); });
    py::dict result;
    result["name"] = device.name;
    result["driver"] = device.driver;
    result["type"] = device.type;
    result["backend"] = nameOf(backend);
    return result;
}

void save(SharedRenderer& shared, const std::filesystem::path& file, bool half,
          const std::variant<std::string, std::vector<std::string>>& output)
{
    requireExtension(file, ".exr");
    const auto* several = std::get_if<std::vector<std::string>>(&output);
    const auto* one = std::get_if<std::string>(&output);
    const auto names = several ? *several : one->empty() ? std::vector<std::string>() : std::vector{*one};
    shared.run([&](Renderer& renderer) { renderer.save(file, half ? PixelType::half : PixelType::full, names); });
}

void bindKnobs(py::class_<SharedRenderer>& renderer)
{
    using namespace py::literals;
    renderer
        .def(
            "knobs", [](SharedRenderer& r) { return toPython(shared(&Renderer::knobs)(r)); },
            "All knobs: {pass: {knob: value}}.")
        .def(
            "get",
            [](SharedRenderer& r, const std::string& knob) { return toPython(shared(&Renderer::knob)(r, knob)); },
            "Value of the knob \"pass.knob\".", "knob"_a)
        .def(
            "set",
            [](SharedRenderer& r, const std::string& knob, const py::object& value) {
                shared (&Renderer::setKnob)(r, knob, toJson(value));
            },
            "Set the knob \"pass.knob\". One that changes kernels or buffers rebuilds its pass, which is a cut. Raises "
            "Error for a wrong name, type, range or choice, or when the pass cannot be built so; all is as before "
            "then.",
            "knob"_a, "value"_a)
        .def(
            "set_everywhere",
            [](SharedRenderer& r, const std::string& name, const py::object& value) {
                return shared(&Renderer::setKnobEverywhere)(r, name, toJson(value));
            },
            "Set a knob of every pass that has it, and return how many have.", "knob"_a, "value"_a);
}

void bindMotion(py::class_<SharedRenderer>& renderer)
{
    using namespace py::literals;
    renderer.def_property_readonly("camera", &camera, CAMERA)
        .def("move_camera", &moveCamera, MOVE_CAMERA, "position"_a = py::none(), "target"_a = py::none(),
             "up"_a = py::none(), "yfov"_a = py::none())
        .def("follow_scene_camera", shared(&Renderer::followSceneCamera),
             "Look from the scene's own camera again, which its animation may move, from the next frame on.")
        .def("move_node", &moveNode, MOVE_NODE, "node"_a, "matrix"_a)
        .def("scene_cameras", &sceneCameras, SCENE_CAMERAS)
        .def("set_time", shared(&Renderer::setTime), "Time of the scene's animation at the next frame, s.", "seconds"_a)
        .def("cut", shared(&Renderer::cut), "Forget all history: the next frame is a first frame.");
}

void bindMeasurements(py::class_<SharedRenderer>& renderer)
{
    renderer.def("gpu_times", shared(&Renderer::gpuTimes), "GPU time of the last frame: {pass: ms}.")
        .def("total_gpu_times", shared(&Renderer::totalGpuTimes),
             "GPU time of all frames since the last cut: {pass: ms}.")
        .def("memory", shared(&Renderer::memory),
             "Device memory: {\"scene\", \"pass.output\" or, of what a pass kept within the last frame, "
             "\"pass.scratch\": bytes}.")
        .def_property_readonly("device_info", &deviceInfo,
                               "The device: a dictionary of name, driver, type and backend.");
}

}  // namespace

void bindRenderer(py::module_& module)
{
    using namespace py::literals;
    py::class_<SharedRenderer> renderer(module, "Renderer", RENDERER);
    renderer
        .def(py::init(&makeRenderer), py::arg("scene").none(false), "graph"_a, "size"_a, "seed"_a = 0,
             "device"_a = py::none(), "backend"_a = py::none(), "validation"_a = false, "fps"_a = 0.0f, "time"_a = 0.0f,
             "energy_compensation"_a = false, "outputs"_a = std::vector<std::string>(), "window"_a = py::none(),
             "bounces"_a = py::none())
        .def("render", &render, RENDER, "frames"_a = 1)
        .def_property_readonly("frame", shared(&Renderer::frame), "Frames rendered since the last cut.")
        .def_property_readonly(
            "size",
            [](SharedRenderer& r) {
                const RendererOptions options = shared(&Renderer::options)(r);
                return std::pair(options.width, options.height);
            },
            "(width, height) of the whole picture in pixels.")
        .def_property_readonly(
            "window",
            [](SharedRenderer& r) {
                const Window window = shared(&Renderer::window)(r);
                return std::tuple(window.x, window.y, window.width, window.height);
            },
            "(x, y, width, height) of what is rendered of the picture: outputs have its size.")
        .def("move_window", shared(&Renderer::moveWindow), MOVE_WINDOW, "x"_a, "y"_a)
        .def_property(
            "seed", [](SharedRenderer& r) { return shared(&Renderer::options)(r).seed; }, shared(&Renderer::setSeed),
            SEED)
        .def(
            "output",
            [](SharedRenderer& r, const std::string& name) { return toArray(shared(&Renderer::output)(r, name)); },
            OUTPUT, "name"_a)
        .def_property_readonly("output_names", shared(&Renderer::outputNames),
                               "Names of the graph's outputs; the first is the picture.")
        .def("read_port", &readPort, READ_PORT, "port"_a)
        .def("_repr_png_", &notebookPng,
             "The graph's first output for a notebook, as write_png shows it; None before the first frame.")
        .def(
            "__enter__", [](SharedRenderer& r) -> SharedRenderer& { return r; }, py::return_value_policy::reference)
        .def(
            "__exit__", [](SharedRenderer& r, const py::args&) { r.close(); }, "Give back the device's memory.")
        .def("save", &save, SAVE, "file"_a, "half"_a = false, "output"_a = "");
    renderer.def("reload", &reload, RELOAD, "graph"_a = py::none());
    bindKnobs(renderer);
    bindEdits(renderer);
    bindMotion(renderer);
    bindMeasurements(renderer);
}

}  // namespace restirpg::python
