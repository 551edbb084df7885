// A scene, a graph and a device, rendering frame by frame. The command line, Python and the benchmarks all go through
// it.
#pragma once

#include "gpu/device.h"
#include "graph/graph.h"
#include "image/image.h"
#include "render/scene_gpu.h"
#include "scene/scene.h"

#include <map>
#include <memory>
#include <optional>
#include <string>

namespace restirpg {

/// Pixels of the whole picture.
struct Window {
    uint32_t x = 0;
    uint32_t y = 0;
    uint32_t width = 0;
    uint32_t height = 0;
};

struct RendererOptions {
    uint32_t width = 640;
    uint32_t height = 360;
    std::optional<Window> window;  ///< of the picture, when not all of it is rendered
    uint32_t seed = 0;
    float time = 0;  ///< s, of the first frame
    float framesPerSecond = 0;  ///< 0: the scene stands still
    bool energyCompensation = false;  ///< rough surfaces give back what single scattering loses
    DeviceOptions device;
    /// Called while the graph's kernels are compiled: seconds each, when they are not in the cache
    CompileProgress compiling;

    /// What of the picture is rendered.
    Window rendered() const { return window.value_or(Window{0, 0, width, height}); }
};

/// Where the camera stands, for users. `target` is a point looked at. World coordinates are in double, since those of a
/// float are coarse far from 0.
struct CameraPose {
    glm::dvec3 position;
    glm::dvec3 target;
    glm::dvec3 up;
    float yfov;  ///< radians
};

class Executor;

class Renderer {
public:
    /// Throws Error for a device, a scene or a pass that cannot be used.
    Renderer(std::shared_ptr<const Scene> scene, std::unique_ptr<Graph> graph, const RendererOptions& options);
    ~Renderer();

    /// Render n more frames. Frame f since the last cut or setTime is rendered at the time of the first one
    /// + f / framesPerSecond.
    void render(uint32_t frames = 1);
    uint32_t frame() const;  ///< frames rendered since the last cut

    /// An output of the graph as a float image. Throws Error when there is no such output, when it is no image, or
    /// before the first frame.
    Image output(const std::string& name);
    std::vector<std::string> outputNames() const;
    /// The raw bytes of a port "pass.output" that somebody reads, as the last frame left it. For tests and tools.
    /// Throws as output().
    std::vector<uint8_t> readPort(const std::string& port);

    nlohmann::json knobs() const;  ///< {"pass": {"knob": value}}
    nlohmann::json knob(const std::string& path) const;  ///< "pass.knob"
    void setKnob(const std::string& path, const nlohmann::json& value);
    uint32_t setKnobEverywhere(const std::string& name, const nlohmann::json& value);

    CameraPose camera() const;
    void moveCamera(const CameraPose& pose);
    /// Look from the scene's own camera again, from the next frame on.
    void followSceneCamera() { cameraOverride_.reset(); }
    /// Give the node a local matrix (relative to its parent), from the next frame on. Throws Error when no node, or
    /// more than one, has that name; names can be empty.
    void moveNode(const std::string& name, const glm::mat4& local);
    /// The same by the node's place in Scene::nodes.
    void moveNode(size_t node, const glm::mat4& local);
    /// The scene's cameras by their names, as they stand now.
    std::vector<std::pair<std::string, CameraPose>> sceneCameras() const;

    /// What can be changed of the scene: {"materials.Wall.base_color": [r, g, b], ...}, see scene/edit.h.
    nlohmann::json parameters() const;
    /// Change some of it for this renderer alone, which has a copy of the scene from then on: pictures are those of a
    /// file with these values, to the byte. Tables of lights and their probabilities follow. Skins stay in the pose in
    /// which they were loaded, and so do the camera and the light that the loader added. Nodes take a new
    /// acceleration structure; moveNode is cheaper for what moves every frame. A cut. Throws WrongValue or WrongIndex;
    /// all is as before then.
    void edit(const std::map<std::string, std::vector<double>>& values);

    /// Render by another graph, or by the same one, its kernels read anew from their files. Knobs that setKnob turned
    /// stay so where the graph has them. Throws Error, located in the graph or the kernel; all is as before then. A
    /// cut.
    void reload(std::unique_ptr<Graph> graph);

    void setTime(float seconds);
    /// Other random numbers from the next frame on. Cut as well: paths of the history replay the numbers of their own
    /// seed. After both the frames are those of a new renderer of that seed, byte for byte, where scene time and poses
    /// are the same too and no node has moved.
    void setSeed(uint32_t seed) { options_.seed = seed; }
    /// Render another part of the picture, of the same size, from the next frame on. A cut: history is of other pixels.
    void moveWindow(uint32_t x, uint32_t y);
    /// What of the picture is rendered: outputs have its size.
    Window window() const;
    /// Forget all history: the next frame is a first frame.
    void cut();

    /// Milliseconds a pass, measured by the device's timestamps: of the last frame; summed since the last cut.
    const std::map<std::string, double>& gpuTimes() const;
    const std::map<std::string, double>& totalGpuTimes() const;
    /// Bytes: "scene", and those of Executor::memory.
    std::map<std::string, uint64_t> memory() const;

    const Scene& scene() const { return *scene_; }
    const Graph& graph() const;
    Device& device() { return *device_; }
    const RendererOptions& options() const { return options_; }

    /// What an EXR header carries: graph JSON, knobs, seed, frames, size, scene file and hash, device, driver, back
    /// end, commit; where they are not the default, time of the first frame, frames per second, camera and its pose,
    /// environment, moved nodes, and what edit() changed. What was changed between frames is told as it is now.
    std::map<std::string, std::string> provenance() const;
    /// Write outputs as one EXR: the first plain, the others as layers. `only`: these, which must be images; empty: all
    /// that are images.
    void save(const std::filesystem::path& file, PixelType type = PixelType::full,
              const std::vector<std::string>& only = {});

private:
    CameraPose poseOf(const CameraNode& camera) const;
    FrameConstants constants(const std::vector<glm::mat4>& pose) const;
    float time() const;
    void addView(std::map<std::string, std::string>& attributes) const;

    RendererOptions options_;
    std::shared_ptr<const Scene> scene_;
    std::unique_ptr<Device> device_;
    std::unique_ptr<SceneGpu> sceneGpu_;
    std::unique_ptr<Executor> executor_;
    std::shared_ptr<Scene> edited_;  ///< the same as scene_ once edit() has made a copy
    nlohmann::json edits_ = nlohmann::json::object();  ///< what edit() was given
    std::map<std::string, nlohmann::json> turned_;  ///< what setKnob was given
    std::vector<std::optional<glm::mat4>> overrides_;
    std::optional<CameraPose> cameraOverride_;
    std::optional<FrameConstants> previous_;  ///< of the frame before, in the same run
    std::vector<glm::mat4> previousPose_;  ///< of that frame, whose nodes stood so
    float start_ = 0;  ///< s, time of the first frame since the last cut or setTime
    uint32_t framesSinceStart_ = 0;
};

}  // namespace restirpg
