#include "render/renderer.h"

#include "core/error_kinds.h"
#include "core/nearest.h"
#include "core/paths.h"
#include "render/executor.h"
#include "render/version.h"
#include "scene/edit.h"

#include <algorithm>
#include <cmath>

namespace restirpg {
namespace {

/// A camera node's world matrix for a pose, relative to `origin`. Differences of places are taken in double: far from 0
/// a float cannot tell the position from what is looked at.
glm::mat4 lookMatrix(const CameraPose& pose, const glm::dvec3& origin)
{
    for (const auto& [name, v] :
         {std::pair("position", pose.position), std::pair("target", pose.target), std::pair("up", pose.up)})
        if (!glm::all(glm::lessThan(glm::abs(v), glm::dvec3(LARGEST_ENTRY))))
            failAs<WrongValue>("the camera's {} ({}, {}, {}) is not finite, or reaches {}; bring it nearer to 0", name,
                               v.x, v.y, v.z, LARGEST_ENTRY);
    const glm::vec3 back(pose.position - pose.target);
    const glm::vec3 right = glm::cross(glm::vec3(pose.up), back);
    if (!std::isfinite(glm::length(right)))
        failAs<WrongValue>("the camera's up direction ({}, {}, {}) is too long; give it a length of 1", pose.up.x,
                           pose.up.y, pose.up.z);
    if (!(glm::length(back) > 0) || !(glm::length(right) > 0))
        failAs<WrongValue>("the camera's target and up direction do not span a view; move the target away from the "
                           "position and up out of line");
    const glm::vec3 z = glm::normalize(back), x = glm::normalize(right);
    return glm::mat4(glm::vec4(x, 0), glm::vec4(glm::cross(z, x), 0), glm::vec4(z, 0),
                     glm::vec4(pose.position - origin, 1));
}

void checkTime(float seconds)
{
    if (!std::isfinite(seconds) || seconds < 0)
        failAs<WrongValue>("a time of {} s: must be finite and at least 0", seconds);
}

void checkWindow(const Window& window, const RendererOptions& options)
{
    const bool inside = window.width >= 1 && window.height >= 1 && uint64_t(window.x) + window.width <= options.width &&
                        uint64_t(window.y) + window.height <= options.height;
    if (!inside)
        failAs<WrongValue>("a window of {}x{} pixels at {},{} does not lie in the picture of {}x{}", window.width,
                           window.height, window.x, window.y, options.width, options.height);
}

void checkOptions(const RendererOptions& options)
{
    constexpr uint32_t LARGEST = 16384;
    if (options.width < 1 || options.height < 1 || options.width > LARGEST || options.height > LARGEST)
        failAs<WrongValue>("an image of {}x{} pixels cannot be rendered; each side is 1 to {}", options.width,
                           options.height, LARGEST);
    if (options.window)
        checkWindow(*options.window, options);
    checkTime(options.time);
    constexpr float SLOWEST = 1e-6f;  // frames per second: a frame still takes finite time
    if (!std::isfinite(options.framesPerSecond) ||
        (options.framesPerSecond != 0 && !(options.framesPerSecond >= SLOWEST)))
        failAs<WrongValue>("{} frames per second: must be 0, where the scene stands still, or finite and at least {}",
                           options.framesPerSecond, SLOWEST);
}

}  // namespace

Renderer::Renderer(std::shared_ptr<const Scene> scene, std::unique_ptr<Graph> graph, const RendererOptions& options)
    : options_(options), scene_(std::move(scene)), overrides_(scene_->nodes.size()), start_(options.time)
{
    checkOptions(options_);
    device_ = std::make_unique<Device>(options_.device);
    sceneGpu_ = std::make_unique<SceneGpu>(*device_, *scene_, poseNodes(*scene_, time(), overrides_),
                                           options_.energyCompensation);
    executor_ =
        std::make_unique<Executor>(*device_, std::move(graph), window().width, window().height, options_.compiling);
}

Renderer::~Renderer() = default;

uint32_t Renderer::frame() const
{
    return executor_->frame();
}

const Graph& Renderer::graph() const
{
    return executor_->graph();
}

/// The constants of the next frame, whose nodes stand so.
FrameConstants Renderer::constants(const std::vector<glm::mat4>& pose) const
{
    FrameConstants constants{};
    constants.scene = sceneGpu_->table();
    const auto& node = scene_->cameras[scene_->camera];
    const float aspect = float(options_.width) / float(options_.height);
    CameraNode camera = node;
    glm::mat4 toWorld = pose[node.node];
    if (cameraOverride_) {
        camera.yfov = cameraOverride_->yfov;
        toWorld = lookMatrix(*cameraOverride_, scene_->origin);
    }
    constants.camera = makeCamera(camera, toWorld, aspect);
    constants.previousCamera = constants.camera;
    if (previous_) {
        constants.previousCamera = previous_->camera;
        constants.rescaled =
            previous_->scene.center != constants.scene.center || previous_->scene.radius != constants.scene.radius;
    }
    const Window seen = window();
    constants.size = {seen.width, seen.height};
    constants.corner = {seen.x, seen.y};
    constants.picture = {options_.width, options_.height};
    constants.seed = options_.seed;
    constants.time = time();
    return constants;
}

void Renderer::render(uint32_t frames)
{
    for (uint32_t i = 0; i < frames; ++i) {
        if (frame() == 0) {
            setTime(time());
            previous_.reset();
        }
        auto pose = poseNodes(*scene_, time(), overrides_);
        sceneGpu_->update(pose, previous_ ? &previousPose_ : nullptr);
        const FrameConstants current = constants(pose);
        executor_->run(current, sceneGpu_->bindings());
        previous_ = current;
        previousPose_ = std::move(pose);
        ++framesSinceStart_;
    }
}

/// The next frame's time, s.
float Renderer::time() const
{
    const double rate = options_.framesPerSecond;
    return rate > 0 ? float(start_ + double(framesSinceStart_) / rate) : start_;
}

Image Renderer::output(const std::string& name)
{
    const auto& outputs = graph().outputs();
    const auto found =
        std::find_if(outputs.begin(), outputs.end(), [&](const auto& output) { return output.name == name; });
    if (found == outputs.end())
        failAs<WrongValue>("graph '{}' has no output '{}'; it has: {}; ports of passes are read where the renderer was "
                           "made with outputs=[\"{}\"]",
                           graph().name(), name, fmt::join(outputNames(), ", "), name);
    const auto& pass = graph().passes()[found->pass];
    const auto& port = pass.interface.outputs()[found->output];
    if (port.type.channels == 0)
        failAs<WrongValue>("output '{}' ({}.{}) is a {}, no image; read it with read_port", name, pass.name, port.name,
                           port.type.name);
    if (frame() == 0)
        fail("output '{}' is not there yet; render at least one frame first", name);
    Image image{window().width, window().height, port.type.channels, {}};
    image.data.resize(size_t(image.width) * image.height * image.channels);
    device_->download(*executor_->latest(found->pass, found->output), image.data.data(),
                      image.data.size() * sizeof(float));
    return image;
}

std::vector<std::string> Renderer::outputNames() const
{
    std::vector<std::string> names;
    for (const auto& output : graph().outputs())
        names.push_back(output.name);
    return names;
}

std::vector<uint8_t> Renderer::readPort(const std::string& path)
{
    const auto& passes = graph().passes();
    for (uint32_t p = 0; p < passes.size(); ++p) {
        const auto& ports = passes[p].interface.outputs();
        for (uint32_t o = 0; o < ports.size(); ++o) {
            if (pathOf(passes[p], ports[o].name) != path)
                continue;
            const Buffer* buffer = executor_->latest(p, o);
            if (!buffer)
                fail("port '{}' is read by nobody in graph '{}', so it is not made; name it as an output of the graph",
                     path, graph().name());
            if (frame() == 0)
                fail("port '{}' is not there yet; render at least one frame first", path);
            return device_->download<uint8_t>(*buffer, ports[o].type.bytes(window().width, window().height));
        }
    }
    std::vector<std::string> names;
    for (const auto& pass : passes)
        for (const auto& port : pass.interface.outputs())
            names.push_back(pathOf(pass, port.name));
    const auto guess = didYouMean(path, names);
    failAs<WrongValue>("graph '{}' has no port '{}'; ports: {}{}{}", graph().name(), path, fmt::join(names, ", "),
                       guess.empty() ? "" : "; ", guess);
}

CameraPose Renderer::camera() const
{
    if (cameraOverride_)
        return *cameraOverride_;
    return poseOf(scene_->cameras[scene_->camera]);
}

/// Where a camera node stands now; the target is one metre ahead.
CameraPose Renderer::poseOf(const CameraNode& camera) const
{
    const auto toWorld = poseNodes(*scene_, time(), overrides_)[camera.node];
    const glm::dvec3 position = glm::dvec3(toWorld[3]) + glm::dvec3(scene_->origin);
    const glm::dvec3 back = glm::normalize(glm::vec3(toWorld[2]));
    return {position, position - back, glm::normalize(glm::vec3(toWorld[1])), camera.yfov};
}

std::vector<std::pair<std::string, CameraPose>> Renderer::sceneCameras() const
{
    std::vector<std::pair<std::string, CameraPose>> cameras;
    for (const auto& camera : scene_->cameras)
        cameras.emplace_back(camera.name, poseOf(camera));
    return cameras;
}

void Renderer::moveCamera(const CameraPose& pose)
{
    if (!(pose.yfov > 0 && pose.yfov < LARGEST_YFOV))
        failAs<WrongValue>(
            "a pinhole camera cannot have a vertical field of view of {} radians; give one between 0 and {}", pose.yfov,
            LARGEST_YFOV);
    lookMatrix(pose, scene_->origin);  // refuses poses that span no view
    cameraOverride_ = pose;
}

void Renderer::moveNode(const std::string& name, const glm::mat4& local)
{
    std::vector<size_t> places;
    for (size_t i = 0; i < scene_->nodes.size(); ++i)
        if (scene_->nodes[i].name == name)
            places.push_back(i);
    if (places.empty())
        failAs<WrongValue>("{}: no node is named '{}'", scene_->file.string(), name);
    if (places.size() > 1)
        failAs<WrongValue>(
            "{}: {} nodes are named '{}'; name one by its place among the scene's nodes: {}", scene_->file.string(),
            places.size(), name,
            fmt::join(places.begin(), places.begin() + std::min<ptrdiff_t>(ptrdiff_t(places.size()), 10), ", "));
    moveNode(places.front(), local);
}

void Renderer::moveNode(size_t node, const glm::mat4& local)
{
    if (node >= overrides_.size())
        failAs<WrongValue>("{}: there is no node {}; the scene has {}, counted from 0", scene_->file.string(), node,
                           overrides_.size());
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!(std::abs(local[column][row]) < LARGEST_ENTRY))
                failAs<WrongValue>("{}: node {} '{}' cannot be moved by a matrix with {}; its entries are numbers "
                                   "below {}",
                                   scene_->file.string(), node, scene_->nodes[node].name, local[column][row],
                                   LARGEST_ENTRY);
    overrides_[node] = local;
}

void Renderer::setTime(float seconds)
{
    checkTime(seconds);
    start_ = seconds;
    framesSinceStart_ = 0;
}

Window Renderer::window() const
{
    return options_.rendered();
}

void Renderer::moveWindow(uint32_t x, uint32_t y)
{
    Window moved = window();
    moved.x = x;
    moved.y = y;
    checkWindow(moved, options_);
    options_.window = moved;
    cut();
}

void Renderer::cut()
{
    executor_->cut();
}

const std::map<std::string, double>& Renderer::gpuTimes() const
{
    return executor_->times();
}

const std::map<std::string, double>& Renderer::totalGpuTimes() const
{
    return executor_->totalTimes();
}

std::map<std::string, uint64_t> Renderer::memory() const
{
    auto bytes = executor_->memory();
    bytes["scene"] = sceneGpu_->bytes();
    return bytes;
}

std::map<std::string, std::string> Renderer::provenance() const
{
    const auto& device = device_->description();
    std::map<std::string, std::string> attributes = {
        {"restirpg.graph", jsonText(graph().description())},
        {"restirpg.knobs", jsonText(knobs())},
        {"restirpg.seed", std::to_string(options_.seed)},
        {"restirpg.frames", std::to_string(frame())},
        {"restirpg.size", fmt::format("{}x{}", options_.width, options_.height)},
        {"restirpg.window", fmt::format("{},{},{},{}", window().x, window().y, window().width, window().height)},
        {"restirpg.scene", escaped(scene_->file.filename().string())},
        {"restirpg.sceneHash", scene_->hash},
        {"restirpg.device", device.name},
        {"restirpg.driver", device.driver},
        {"restirpg.backend", nameOf(device_->backend())},
        {"restirpg.energyCompensation", options_.energyCompensation ? "true" : "false"},
        {"restirpg.commit", COMMIT}};
    if (cameraOverride_) {
        const auto& [position, target, up, yfov] = *cameraOverride_;
        attributes["restirpg.pose"] = fmt::format("{},{},{},{},{},{},{},{},{},{}", position.x, position.y, position.z,
                                                  target.x, target.y, target.z, up.x, up.y, up.z, yfov);
    }
    if (!edits_.empty())
        attributes["restirpg.sceneEdits"] = jsonText(edits_);
    if (const auto moved = matricesOf(*scene_, overrides_); !moved.empty())
        attributes["restirpg.movedNodes"] = jsonText(moved);
    addView(attributes);
    return attributes;
}

/// What was asked for besides the scene's own camera, light and time.
void Renderer::addView(std::map<std::string, std::string>& attributes) const
{
    if (start_ != 0)
        attributes["restirpg.time"] = fmt::format("{}", start_);
    if (options_.framesPerSecond != 0)
        attributes["restirpg.fps"] = fmt::format("{}", options_.framesPerSecond);
    if (scene_->camera != 0)
        attributes["restirpg.camera"] = std::to_string(scene_->camera);
    if (const auto& given = scene_->givenEnvironment) {
        attributes["restirpg.environment"] = escaped(given->name);
        if (!given->hash.empty())
            attributes["restirpg.environmentHash"] = given->hash;
    }
}

void Renderer::save(const std::filesystem::path& file, PixelType type, const std::vector<std::string>& only)
{
    refuseInput(file, scene_->files);
    refuseInput(file, graph().namedFiles());
    std::vector<std::string> names = only;
    if (only.empty())
        for (const auto& named : graph().outputs())
            if (graph().passes()[named.pass].interface.outputs()[named.output].type.channels > 0)
                names.push_back(named.name);
    std::vector<Layer> layers;
    for (const auto& name : names)
        layers.push_back({layers.empty() ? "" : name, output(name)});
    writeExr(file, layers, type, provenance());
}

}  // namespace restirpg
