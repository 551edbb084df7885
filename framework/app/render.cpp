// restirpg render GRAPH --scene S ...: render frames and write the graph's outputs.
#include "app/commands.h"

#include "app/interruption.h"
#include "app/progress.h"
#include "core/error.h"
#include "core/log.h"
#include "core/output_file.h"
#include "core/paths.h"
#include "core/table.h"
#include "image/metrics.h"
#include "render/bounce_cap.h"
#include "render/renderer.h"
#include "scene/gltf.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <optional>

namespace restirpg {
namespace {

struct RenderOptions {
    std::string graph;
    std::string scene;
    std::string size = "640x360";
    std::vector<uint32_t> window;  ///< x, y, width, height in the picture; empty: all of it
    uint32_t frames = 16;
    uint32_t keepEvery = 0;  ///< frames; 0: only at the end
    std::string exr;
    std::string png;
    /// Outputs of the graph or of its passes, the first is the picture; empty: all of the graph's
    std::vector<std::string> outputs;
    std::string reference;
    std::optional<std::string> environment;  ///< in place of the scene's
    bool allowOutside = false;
    std::vector<std::string> knobs;  ///< "pass.knob=value"
    std::optional<uint32_t> bounces;
    uint32_t camera = 0;
    std::vector<double> pose;  ///< position, target, up, vertical field of view, radians; empty: the camera's own
    bool half = false;
    DisplayTransform display;
    RendererOptions renderer;
};

void parseSize(const std::string& text, RendererOptions& options)
{
    const char* const end = text.data() + text.size();
    const auto width = std::from_chars(text.data(), end, options.width);
    const bool divided = width.ec == std::errc() && width.ptr != end && *width.ptr == 'x';
    const auto height = divided ? std::from_chars(width.ptr + 1, end, options.height) : width;
    if (!divided || height.ec != std::errc() || height.ptr != end)
        fail("--size {}: write WIDTHxHEIGHT in pixels, as in 640x360", text);
}

/// What would stop us only after the rendering is asked before it.
void checkFiles(const RenderOptions& options)
{
    if (options.exr.empty() && options.png.empty() && options.reference.empty())
        fail("nothing to do with the picture; name a file with -o out.exr or --png out.png, or a --reference to "
             "compare with");
    for (const auto& [file, extension] : {std::pair(options.exr, ".exr"), std::pair(options.png, ".png")}) {
        if (file.empty())
            continue;
        requireExtension(file, extension);
        checkWritable(file);
    }
    if (!options.png.empty())
        checkDisplay(options.display);
}

/// Everything that is read: writing over it would destroy what the picture is made from.
std::vector<std::filesystem::path> inputsOf(const RenderOptions& options, const Graph& graph, const Scene& scene)
{
    std::vector<std::filesystem::path> inputs = scene.files;
    for (const auto& file : {options.graph, options.reference, options.display.config})
        if (!file.empty())
            inputs.emplace_back(file);
    const auto named = graph.namedFiles();
    inputs.insert(inputs.end(), named.begin(), named.end());
    return inputs;
}

/// Bounce cap first (the user's, else the scene's own), then the knobs named one by one.
void setKnobs(Graph& graph, const RenderOptions& options, const Scene& scene)
{
    const uint32_t reached = capBounces(graph, scene, options.bounces);
    if (options.bounces && reached == 0)
        fail("--bounces {}: no pass of graph '{}' has a knob 'bounces'", *options.bounces, graph.name());
    for (const auto& setting : options.knobs) {
        const auto equals = setting.find('=');
        if (equals == std::string::npos)
            fail("--set {}: write PASS.KNOB=VALUE, as in paths.bounces=4", setting);
        graph.setKnobFromText(setting.substr(0, equals), setting.substr(equals + 1));
    }
    checkCapped(graph, scene, options.bounces);
}

const OutputPort& portOf(const Graph& graph, const GraphOutput& output)
{
    return graph.passes()[output.pass].interface.outputs()[output.output];
}

/// Whether a file that is asked for cannot hold the picture.
void checkPicture(const GraphOutput& output, uint32_t channels, const RenderOptions& options)
{
    if (!options.png.empty() && channels != 1 && channels != 3)
        fail("output '{}' has {} channels, a PNG has 1 or 3; choose another with --output, or -o for an EXR",
             output.name, channels);
    if (!options.reference.empty() && channels != 3)
        fail("output '{}' has {} channels, a --reference is compared with 3; choose another with --output", output.name,
             channels);
}

/// The output that is the picture: the user's first, else the graph's. Outputs that no image file can hold are named.
std::string chooseOutput(Graph& graph, RenderOptions& options)
{
    for (const auto& name : options.outputs)
        graph.addOutput(name);
    std::vector<std::string> images;
    for (const auto& output : graph.outputs())
        if (portOf(graph, output).type.channels > 0)
            images.push_back(output.name);
    std::string chosen = options.outputs.empty() ? graph.outputs().front().name : options.outputs.front();
    for (const auto& output : graph.outputs()) {
        const auto& type = portOf(graph, output).type;
        const bool asked = std::count(options.outputs.begin(), options.outputs.end(), output.name) > 0;
        if ((asked || output.name == chosen) && type.channels == 0)
            fail("output '{}' is a {}, which no image file can hold; choose one with --output: {}", output.name,
                 type.name, fmt::join(images, ", "));
        if (output.name == chosen)
            checkPicture(output, type.channels, options);
        if (options.outputs.empty() && type.channels == 0)
            warn("output '{}' is a {}, which no image file can hold; it is left out", output.name, type.name);
    }
    return chosen;
}

Image readReference(const RenderOptions& options)
{
    if (options.reference.empty())
        return {};
    Image reference = readExr(options.reference);
    const auto& renderer = options.renderer;
    const Window seen = renderer.rendered();
    if (reference.width != seen.width || reference.height != seen.height)
        fail("{}: the reference has {}x{} pixels; {} of that size", options.reference, reference.width,
             reference.height,
             renderer.window ? "render a --window"
                             : fmt::format("render with --size {}x{}", reference.width, reference.height));
    return reference;
}

using Header = std::map<std::string, std::string>;

/// An attribute, or what stands for one that is not there.
std::string attribute(const Header& header, const std::string& name, const std::string& otherwise = "")
{
    const auto found = header.find("restirpg." + name);
    return found == header.end() ? otherwise : found->second;
}

/// Refuses pixels of another picture, or other pixels of it.
void checkReferencePixels(const RenderOptions& options, const Header& header)
{
    const auto& asked = options.renderer;
    const Window seen = asked.rendered();
    const std::string size = fmt::format("{}x{}", asked.width, asked.height);
    const std::string window = fmt::format("{},{},{},{}", seen.x, seen.y, seen.width, seen.height);
    const std::string ownSize = attribute(header, "size", size), ownWindow = attribute(header, "window", window);
    if (ownSize != size || ownWindow != window)
        fail("{}: this reference is of other pixels ({} of a picture of {}; here it is {} of {}); give one that was "
             "rendered with the same --size and --window, or leave out --reference",
             options.reference, ownWindow, ownSize, window, size);
}

/// Two files of one name may differ, and one file may have two names: where both have a hash, that decides.
void warnOfEnvironment(const RenderOptions& options, const Header& header, const Scene& scene)
{
    const auto here = scene.givenEnvironment.value_or(GivenEnvironment{});
    const GivenEnvironment own{attribute(header, "environment"), attribute(header, "environmentHash")};
    const bool same = own.hash.empty() || here.hash.empty() ? own.name == escaped(here.name) : own.hash == here.hash;
    const auto shown = [](const GivenEnvironment& given) {
        if (given.name.empty())
            return std::string("that of the scene");
        return given.hash.empty() ? given.name : fmt::format("{} (hash {})", given.name, given.hash);
    };
    if (!same)
        warn("{}: its environment is {}, here it is {}: the difference counts as error", options.reference, shown(own),
             shown(here));
}

/// What the header says is compared with what is rendered; of what it does not say nothing is known.
void checkReferenceHeader(const RenderOptions& options, const Scene& scene)
{
    if (options.reference.empty())
        return;
    const auto header = readExrAttributes(options.reference);
    const auto hash = attribute(header, "sceneHash", scene.hash);
    if (hash != scene.hash)
        fail("{}: this reference is of another scene, or of another version of it ({}, hash {}; here it is {}); give "
             "one that was rendered of this scene, or leave out --reference",
             options.reference, attribute(header, "scene", "unnamed"), hash, scene.hash);
    checkReferencePixels(options, header);
    if (header.contains("restirpg.sceneHash"))
        warnOfEnvironment(options, header, scene);
}

/// Warns of a reference that shows another view: says what differs.
void warnOfView(const RenderOptions& options, const Renderer& renderer)
{
    if (options.reference.empty())
        return;
    const auto own = readExrAttributes(options.reference), here = renderer.provenance();
    if (!own.contains("restirpg.sceneHash"))
        return;
    for (const auto& [name, otherwise] : {std::pair("camera", "0"), std::pair("pose", "that of the camera"),
                                          std::pair("time", "0"), std::pair("energyCompensation", "false")})
        if (const auto a = attribute(own, name, otherwise), b = attribute(here, name, otherwise); a != b)
            warn("{}: its {} is {}, here it is {}: the difference counts as error", options.reference, name, a, b);
}

void writeFiles(Renderer& renderer, const RenderOptions& options, const std::string& shown)
{
    if (!options.exr.empty())
        renderer.save(options.exr, options.half ? PixelType::half : PixelType::full, options.outputs);
    if (!options.png.empty())
        writePng(options.png, renderer.output(shown), options.display);
}

/// --keep-every: what cannot be written now may be when all is rendered.
void keep(Renderer& renderer, const RenderOptions& options, const std::string& shown)
{
    try {
        writeFiles(renderer, options, shown);
    } catch (const Error& error) {
        warn("{}; frame {} is not kept", error.what(), renderer.frame());
    }
}

/// Renders all frames, or until a signal comes; returns seconds.
double renderFrames(Renderer& renderer, const RenderOptions& options, const std::string& shown,
                    const Interruption& interruption)
{
    const auto start = std::chrono::steady_clock::now();
    Progress progress("rendering", options.frames);
    while (renderer.frame() < options.frames && (renderer.frame() == 0 || interruption.signal() == 0)) {
        renderer.render(1);
        progress.advance();
        if (options.keepEvery > 0 && renderer.frame() % options.keepEvery == 0 && renderer.frame() < options.frames)
            keep(renderer, options, shown);
    }
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

void printTimes(const Renderer& renderer, double seconds)
{
    const uint32_t frames = renderer.frame();
    Table table({"pass", "GPU ms/frame"});
    double total = 0;
    for (const auto& [pass, milliseconds] : renderer.totalGpuTimes()) {
        table.add({pass, fmt::format("{:.3f}", milliseconds / frames)});
        total += milliseconds;
    }
    table.add({"all", fmt::format("{:.3f}", total / frames)});
    fmt::print("{} frame{} in {:.2f} s\n{}", frames, frames == 1 ? "" : "s", seconds, table.text());
}

/// Graphs name their count of dropped frames per pixel `invalid`.
void reportInvalid(Renderer& renderer)
{
    double count = 0;
    for (const auto& output : renderer.graph().outputs())
        if (output.name == "invalid" && portOf(renderer.graph(), output).type.channels == 1)
            for (const float frames : renderer.output(output.name).data)
                count += frames;
    if (count > 0)
        warn("{} of {} samples were NaN, infinite or too large to add up and are left out: the mean is wrong where "
             "they were, which "
             "output 'invalid' shows",
             count, renderer.frame() * double(renderer.window().width) * renderer.window().height);
}

/// What was written, and its errors.
void printResults(Renderer& renderer, const RenderOptions& options, const std::string& shown, const Image& reference)
{
    for (const auto& file : {options.exr, options.png})
        if (!file.empty())
            fmt::print("wrote {}\n", escaped(file));
    if (!reference.empty()) {
        const Errors errors = measureErrors(renderer.output(shown), reference);
        fmt::print("against {}: MAPE {:.4g}%, relMSE {:.4g}, RMSE {:.4g}, bias {:+.3g}%, invalid pixels {}\n",
                   escaped(options.reference), 100 * errors.mape, errors.relMse, errors.rmse, 100 * errors.bias,
                   errors.invalid);
    }
}

void render(RenderOptions& options)
{
    parseSize(options.size, options.renderer);
    if (const auto& w = options.window; !w.empty())
        options.renderer.window = Window{w[0], w[1], w[2], w[3]};
    if (!(std::abs(options.display.exposure) <= 100))
        fail("--exposure {}: must be a number of stops from -100 to 100", options.display.exposure);
    checkFiles(options);
    auto graph = std::make_unique<Graph>(readGraphFile(options.graph), Plugins());
    const std::string shown = chooseOutput(*graph, options);
    const Image reference = readReference(options);
    const auto scene = std::make_shared<const Scene>(
        loadScene(options.scene, options.environment, options.camera, options.allowOutside));
    checkReferenceHeader(options, *scene);
    setKnobs(*graph, options, *scene);
    for (const auto& file : {options.exr, options.png})
        refuseInput(file, inputsOf(options, *graph, *scene));

    std::optional<Progress> compiling;
    options.renderer.compiling = [&](uint32_t done, uint32_t total) {
        if (done == 0)
            compiling.emplace("compiling kernels", total);
        else
            compiling->advance();
    };
    Renderer renderer(scene, std::move(graph), options.renderer);
    compiling.reset();
    if (const auto& p = options.pose; !p.empty())
        renderer.moveCamera({{p[0], p[1], p[2]}, {p[3], p[4], p[5]}, {p[6], p[7], p[8]}, float(p[9])});
    warnOfView(options, renderer);
    const Interruption interruption;
    const auto& device = renderer.device().description();
    fmt::print("{}, {}, {} back end\n", device.name, device.driver, nameOf(renderer.device().backend()));
    std::fflush(stdout);
    const double seconds = renderFrames(renderer, options, shown, interruption);
    if (interruption.signal() != 0)
        logInfo(fmt::format("interrupted after {} of {} frames, which are kept", renderer.frame(), options.frames));
    // Files first: standard output may be gone by now.
    reportInvalid(renderer);
    writeFiles(renderer, options, shown);
    printTimes(renderer, seconds);
    printResults(renderer, options, shown, reference);
    if (interruption.signal() != 0)
        interruption.end();
}

void addInputOptions(CLI::App& command, RenderOptions& options)
{
    command.add_option("GRAPH", options.graph, "Graph file (.py or .json)")->required();
    command.add_option("--scene", options.scene, "glTF 2.0 scene (.gltf or .glb)")->required();
    command.add_flag("--allow-outside", options.allowOutside,
                     "Let the scene read files that lie outside of its own folder");
    command.add_option(
        "--environment", options.environment,
        "Environment light in place of the scene's: an equirectangular .exr or .hdr, or a radiance r,g,b");
    command.add_option("--camera", options.camera, "Number of the scene's camera, counted from 0");
    command
        .add_option("--pose", options.pose,
                    "Where the camera stands, as the live viewer copies it: position, target, up (x,y,z each) and the "
                    "vertical field of view in radians")
        ->delimiter(',')
        ->expected(10);
    command.add_option("--time", options.renderer.time, "Time of the first frame, s");
    command.add_option("--fps", options.renderer.framesPerSecond,
                       "Frames per second of scene time; 0: the scene stands still");
    command.add_option("--bounces", options.bounces,
                       "Bounce cap of every pass that has one (default: the scene's, or the graph's own)");
    command.add_flag("--energy-compensation", options.renderer.energyCompensation,
                     "Rough metal and glass give back the light that single-scattering GGX loses");
    command.add_option("--set", options.knobs, "Set a knob: PASS.KNOB=VALUE; may be repeated")->allow_extra_args(false);
}

void addOutputOptions(CLI::App& command, RenderOptions& options)
{
    command.add_option("--size", options.size, "WIDTHxHEIGHT in pixels")->capture_default_str();
    command
        .add_option("--window", options.window,
                    "X,Y,WIDTH,HEIGHT: render only these pixels of the picture, as they are in it")
        ->delimiter(',')
        ->expected(4);
    command.add_option("--frames", options.frames, "Frames to render")
        ->check(CLI::Range(1u, 100000000u))
        ->capture_default_str();
    command.add_option("--keep-every", options.keepEvery, "Also write the files every so many frames");
    command.add_option("--seed", options.renderer.seed, "Seed of all random numbers")->capture_default_str();
    command.add_option("-o,--out", options.exr, "EXR file: the first output as R, G, B, the others as layers");
    command.add_flag("--half", options.half, "Half floats in the EXR");
    command
        .add_option(
            "--output", options.outputs,
            "Write only this output of the graph, or this port of a pass, such as albedo, normal, depth; may be "
            "repeated, the first is the picture")
        ->allow_extra_args(false);
    command.add_option("--png", options.png, "PNG file of the first output");
    command.add_option("--exposure", options.display.exposure, "Exposure of the PNG in stops, -100 to 100");
    command.add_option("--ocio", options.display.config,
                       "OpenColorIO config for the PNG (default: a small built-in one)");
    command.add_option("--display", options.display.display, "Display of that config");
    command.add_option("--view", options.display.view, "View of that display");
    command.add_option("--reference", options.reference, "EXR against which the first output's errors are measured");
}

void addDeviceOptions(CLI::App& command, DeviceOptions& options)
{
    command.add_option("--device", options.device,
                       "The device's number or a part of its name, as restirpg devices lists them");
    command.add_option("--backend", options.backend,
                       "Ray tracing: software or rayquery (default: what suits the device)");
    command.add_flag("--validation", options.validation, "Turn the Vulkan validation layer on");
}

}  // namespace

void addRenderCommand(CLI::App& app)
{
    auto* command = app.add_subcommand("render", "Render a scene through a graph");
    auto options = std::make_shared<RenderOptions>();
    addInputOptions(*command, *options);
    addOutputOptions(*command, *options);
    addDeviceOptions(*command, options->renderer.device);
    command->callback([options] { render(*options); });
}

}  // namespace restirpg
