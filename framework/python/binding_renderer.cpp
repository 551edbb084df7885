// The renderer, frame by frame.
#include "binding.h"

#include "core/error.h"
#include "render/renderer.h"

#include <optional>

namespace restirpg::python {
namespace {

constexpr const char* RENDERER = R"(A scene, a graph and a device, rendering frame by frame.

scene: from load_scene. graph: from load_graph, or a restirpg.Graph, or its description as a dictionary.
size: (width, height) in pixels. seed: of all random numbers; the same seed gives the same bytes on the same device.
device: number or part of the name as `restirpg devices` lists them; None: the best one. backend: "software", "rayquery"
or None for what suits the device. validation: run under the Vulkan validation layer. fps: frames a second of scene time;
0: the scene stands still. time: of the first frame, s. energy_compensation: rough metal and glass give back the light that
single-scattering GGX loses.

A scene that has a bounce cap of its own sets the knob "bounces" of every pass to it.)";

constexpr const char* SEED = R"(Of all random numbers from the next frame on: 0 to 2^32 - 1.

`renderer.seed = s; renderer.cut()` begins a run that has the bytes of a new Renderer with that seed, at a fraction of
its cost. Scene time, camera, nodes and knobs stay as they are: set_time(0) where the scene is animated. Without the
cut, paths of the history would replay numbers of another seed than their own.)";

constexpr const char* RENDER =
    R"(Render `frames` more frames. Other Python threads run meanwhile; Ctrl-C ends it between two frames.)";

constexpr const char* OUTPUT =
    R"(An output of the graph after the last frame: float32 (H, W, C), linear, rows from the top.

Raises Error when there is no such output, when it is no image, or before the first frame.)";

constexpr const char* READ_PORT =
    R"(Raw bytes of any port "pass.output" that somebody reads, after the last frame: uint8 (N,).)";

constexpr const char* CAMERA =
    R"(Where the camera stands: a dictionary of position and target (m), up, and yfov (radians).)";

constexpr const char* MOVE_CAMERA =
    R"(Move the camera from the next frame on; what is None stays. History is kept: cut() forgets it.

position, target: points (3,), m. up: direction (3,). yfov: vertical field of view, radians.)";

constexpr const char* MOVE_NODE =
    R"(Give a node a new local matrix (4, 4) relative to its parent, from the next frame on.

Column vectors: the translation is the last column.)";

constexpr const char* SAVE = R"(Write the graph's outputs as one EXR: the first as R, G, B, the others as layers.

half: half floats. output: write only this one. The header carries the graph, its knobs, seed, frames, scene, device and
commit.)";

nlohmann::json describe(const py::object& graph)
{
    if (py::isinstance<GraphDescription>(graph))
        return graph.cast<const GraphDescription&>().json;
    // A restirpg.Graph of the package's pure-Python half.
    if (py::hasattr(graph, "description") && PyCallable_Check(graph.attr("description").ptr()))
        return toJson(graph.attr("description")());
    if (py::isinstance<py::dict>(graph))
        return toJson(graph);
    fail("{} is no graph; give what load_graph returns, a restirpg.Graph or a dictionary",
         py::repr(graph).cast<std::string>());
}

std::unique_ptr<Renderer> makeRenderer(const std::shared_ptr<Scene>& scene, const py::object& graph,
                                       const std::pair<uint32_t, uint32_t>& size, uint32_t seed,
                                       const std::optional<py::object>& device,
                                       const std::optional<std::string>& backend, bool validation, float fps,
                                       float time, bool energyCompensation)
{
    RendererOptions options;
    options.width = size.first;
    options.height = size.second;
    options.seed = seed;
    options.framesPerSecond = fps;
    options.time = time;
    options.energyCompensation = energyCompensation;
    options.device = {device ? py::str(*device).cast<std::string>() : "", backend.value_or(""), validation};
    auto description = describe(graph);
    py::gil_scoped_release release;
    auto checked = std::make_unique<Graph>(std::move(description), Plugins());
    if (scene->bounceCap)
        checked->setKnobEverywhere("bounces", *scene->bounceCap);
    return std::make_unique<Renderer>(scene, std::move(checked), options);
}

void render(Renderer& renderer, uint32_t frames)
{
    for (uint32_t i = 0; i < frames; ++i) {
        {
            py::gil_scoped_release release;
            renderer.render(1);
        }
        if (PyErr_CheckSignals() != 0)
            throw py::error_already_set();
    }
}

py::array_t<uint8_t> readPort(Renderer& renderer, const std::string& port)
{
    const auto bytes = renderer.readPort(port);
    return py::array_t<uint8_t>(py::ssize_t(bytes.size()), bytes.data());
}

using Triple = std::array<float, 3>;

Triple triple(const glm::vec3& v)
{
    return {v.x, v.y, v.z};
}

py::dict camera(const Renderer& renderer)
{
    const CameraPose pose = renderer.camera();
    py::dict result;
    result["position"] = triple(pose.position);
    result["target"] = triple(pose.target);
    result["up"] = triple(pose.up);
    result["yfov"] = pose.yfov;
    return result;
}

void moveCamera(Renderer& renderer, const std::optional<Triple>& position, const std::optional<Triple>& target,
                const std::optional<Triple>& up, std::optional<float> yfov)
{
    CameraPose pose = renderer.camera();
    const auto take = [](glm::vec3& to, const std::optional<Triple>& from) {
        if (from)
            to = {(*from)[0], (*from)[1], (*from)[2]};
    };
    take(pose.position, position);
    take(pose.target, target);
    take(pose.up, up);
    pose.yfov = yfov.value_or(pose.yfov);
    renderer.moveCamera(pose);
}

void moveNode(Renderer& renderer, const std::string& name, const FloatArray& matrix)
{
    if (matrix.ndim() != 2 || matrix.shape(0) != 4 || matrix.shape(1) != 4)
        fail("node '{}' is moved by a matrix (4, 4)", name);
    glm::mat4 local;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            local[column][row] = matrix.at(row, column);
    renderer.moveNode(name, local);
}

py::dict deviceInfo(Renderer& renderer)
{
    const DeviceDescription& device = renderer.device().description();
    py::dict result;
    result["name"] = device.name;
    result["driver"] = device.driver;
    result["type"] = device.type;
    result["backend"] = renderer.device().backend() == Backend::rayQuery ? "rayquery" : "software";
    return result;
}

void bindKnobs(py::class_<Renderer>& renderer)
{
    using namespace py::literals;
    renderer
        .def(
            "knobs", [](const Renderer& r) { return toPython(r.knobs()); }, "All knobs: {pass: {knob: value}}.")
        .def(
            "get", [](const Renderer& r, const std::string& knob) { return toPython(r.knob(knob)); },
            "Value of the knob \"pass.knob\".", "knob"_a)
        .def(
            "set",
            [](Renderer& r, const std::string& knob, const py::object& value) { r.setKnob(knob, toJson(value)); },
            "Set the knob \"pass.knob\". One that changes kernels or buffers rebuilds its pass, which is a cut. Raises "
            "Error for a wrong name, type, range or choice.",
            "knob"_a, "value"_a)
        .def(
            "set_everywhere",
            [](Renderer& r, const std::string& name, const py::object& value) {
                return r.setKnobEverywhere(name, toJson(value));
            },
            "Set a knob of every pass that has it, and return how many have.", "knob"_a, "value"_a);
}

void bindMotion(py::class_<Renderer>& renderer)
{
    using namespace py::literals;
    renderer.def_property_readonly("camera", &camera, CAMERA)
        .def("move_camera", &moveCamera, MOVE_CAMERA, "position"_a = py::none(), "target"_a = py::none(),
             "up"_a = py::none(), "yfov"_a = py::none())
        .def("move_node", &moveNode, MOVE_NODE, "name"_a, "matrix"_a)
        .def("set_time", &Renderer::setTime, "Time of the scene's animation at the next frame, s.", "seconds"_a)
        .def("cut", &Renderer::cut, "Forget all history: the next frame is a first frame.");
}

void bindMeasurements(py::class_<Renderer>& renderer)
{
    renderer
        .def(
            "gpu_times", [](const Renderer& r) { return r.gpuTimes(); }, "GPU time of the last frame: {pass: ms}.")
        .def(
            "total_gpu_times", [](const Renderer& r) { return r.totalGpuTimes(); },
            "GPU time of all frames since the last cut: {pass: ms}.")
        .def("memory", &Renderer::memory, "Device memory: {\"scene\" or \"pass.output\": bytes}.")
        .def_property_readonly("device_info", &deviceInfo,
                               "The device: a dictionary of name, driver, type and backend.");
}

}  // namespace

void bindRenderer(py::module_& module)
{
    using namespace py::literals;
    py::class_<Renderer> renderer(module, "Renderer", RENDERER);
    renderer
        .def(py::init(&makeRenderer), "scene"_a, "graph"_a, "size"_a, "seed"_a = 0, "device"_a = py::none(),
             "backend"_a = py::none(), "validation"_a = false, "fps"_a = 0.0f, "time"_a = 0.0f,
             "energy_compensation"_a = false)
        .def("render", &render, RENDER, "frames"_a = 1)
        .def_property_readonly("frame", &Renderer::frame, "Frames rendered since the last cut.")
        .def_property_readonly(
            "size", [](const Renderer& r) { return std::pair(r.options().width, r.options().height); },
            "(width, height) in pixels.")
        .def_property(
            "seed", [](const Renderer& r) { return r.options().seed; }, &Renderer::setSeed, SEED)
        .def(
            "output", [](Renderer& r, const std::string& name) { return toArray(r.output(name)); }, OUTPUT, "name"_a)
        .def_property_readonly("output_names", &Renderer::outputNames,
                               "Names of the graph's outputs; the first is the picture.")
        .def("read_port", &readPort, READ_PORT, "port"_a)
        .def(
            "save",
            [](Renderer& r, const std::filesystem::path& file, bool half, const std::string& output) {
                r.save(file, half ? PixelType::half : PixelType::full, output);
            },
            SAVE, "file"_a, "half"_a = false, "output"_a = "");
    bindKnobs(renderer);
    bindMotion(renderer);
    bindMeasurements(renderer);
}

}  // namespace restirpg::python
