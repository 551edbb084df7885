#include "Shared.h"
#include "render/frame.h"

#include <algorithm>

namespace restirpg {

static_assert(sizeof(PathReservoir) == 92);

namespace {

/// Fewest pixels of the radius of spatial reuse, whatever the size of the image: below, no neighbours would be left (ALGORITHMS O10).
constexpr float LEAST_RADIUS = 3.0f;
/// Lines of the image for which the knob `radius` is in pixels.
constexpr float RADIUS_LINES = 1080.0f;
/// In the order of REUSE_FAULT_*.
const std::vector<std::string> FAULTS = {"none", "jacobian", "mis", "cap", "previous_camera", "confidence"};

}  // namespace

class ReSTIRReuse final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<PathReservoir>("PathReservoir");
        io.input("surface", surface_, perPixel<Hit>("Surface"), "primary hit of each pixel, through its centre");
        io.input("candidates", candidates_, reservoir, "one candidate path a pixel, of this frame");
        io.optionalInput("motion", motion_, image(2), "where the point was in the frame before, minus where it is, in pixels");
        io.optionalInput("previous_surface", previousSurface_, perPixel<Hit>("Surface"),
                         "the surface one frame ago: prev(\"gbuffer.surface\")");
        io.optionalInput("history", history_, reservoir, "the output reservoirs, one frame ago: prev(\"reuse.reservoirs\")");
        io.output("radiance", radiance_, image(3), "light of the chosen path, W/sr/m^2");
        io.output("reservoirs", reservoirs_, reservoir, "the path that each pixel ends the frame with");
        io.knob("temporal", temporal_, "merge with the pixel of the frame before");
        io.knob("cap", cap_, 1, 1000, "confidence of the history, at most, times that of the pixel's own candidate (Lin et al. 2022: 20)");
        io.knob("rounds", rounds_, 0, 8, "rounds of spatial reuse; 0: none");
        io.knob("neighbours", neighbours_, 1, MAX_REUSE_NEIGHBOURS, "pixels drawn in one round");
        io.knob("radius", radius_, 1, 1000, "of the disk of neighbours, in pixels of an image of 1080 lines; never below 3 pixels of this one");
        io.knob("normal_threshold", normalThreshold_, -1, 1, "least cosine between the shading normals of merged pixels");
        io.knob("depth_threshold", depthThreshold_, 0, 1000, "most relative difference of their distances from the camera");
        io.choice("fault", fault_, FAULTS, "for tests only: build this mistake in, the picture is wrong");
        io.structural();
    }

    void build(Device& device) override
    {
        device_ = &device;
        const auto fault = std::find(FAULTS.begin(), FAULTS.end(), fault_) - FAULTS.begin();
        const Defines defines = {{"RESTIRPG_FAULT", std::to_string(fault) + "u"}};
        temporalKernel_ = Kernel(device, passFile("Temporal.comp"), defines);
        spatialKernel_ = Kernel(device, passFile("Spatial.comp"), defines);
        shadeKernel_ = Kernel(device, passFile("Shade.comp"));
    }

    void record(Frame& frame) override
    {
        const int temporalInputs = int(bool(motion_)) + int(bool(previousSurface_)) + int(bool(history_));
        if (temporalInputs != 0 && temporalInputs != 3)
            fail("ReSTIRReuse: temporal reuse needs all of motion, previous_surface and history; wire them all or none");
        const float scale = float(frame.height()) / RADIUS_LINES;
        ReuseParameters parameters{frame.constants(),
                                   surface_->address(),
                                   addressOf(previousSurface_),
                                   addressOf(motion_),
                                   candidates_->address(),
                                   addressOf(history_),
                                   0,
                                   addressOf(radiance_),
                                   cap_,
                                   std::max(radius_ * scale, LEAST_RADIUS),
                                   normalThreshold_,
                                   depthThreshold_,
                                   neighbours_,
                                   0};
        // Each stage reads one buffer and writes another; the last one writes the output.
        uint32_t stage = rounds_;
        parameters.reservoirs = buffer(frame, stage);
        const bool temporal = temporal_ && history_ && !history_.empty;
        if (temporal) {
            frame.dispatchPixels(temporalKernel_, parameters);
            parameters.source = parameters.reservoirs;
        }
        for (parameters.round = 0; parameters.round < rounds_; ++parameters.round) {
            parameters.reservoirs = buffer(frame, --stage);
            frame.dispatchPixels(spatialKernel_, parameters);
            parameters.source = parameters.reservoirs;
        }
        if (!temporal && rounds_ == 0)
            frame.copy(*candidates_.resource, output(frame));
        if (radiance_) {
            parameters.source = !temporal && rounds_ == 0 ? candidates_->address() : parameters.source;
            frame.dispatchPixels(shadeKernel_, parameters);
        }
    }

private:
    /// Where a stage writes that still has `left` stages after it: the output for the last, else one of two buffers of our own.
    Address buffer(const Frame& frame, uint32_t left)
    {
        return left == 0 ? output(frame).address() : scratch(frame, left % 2).address();
    }

    /// The output when somebody reads it, else a buffer of our own.
    const Buffer& output(const Frame& frame) { return reservoirs_ ? *reservoirs_.resource : scratch(frame, 2); }

    const Buffer& scratch(const Frame& frame, uint32_t index)
    {
        const uint64_t bytes = uint64_t(frame.width()) * frame.height() * sizeof(PathReservoir);
        if (scratch_[index].bytes() < bytes)
            scratch_[index] = device_->createBuffer(bytes, "path reservoirs");
        return scratch_[index];
    }

    In<Buffer> surface_, candidates_, motion_, previousSurface_, history_;
    Out<Buffer> radiance_, reservoirs_;
    bool temporal_ = true;
    float cap_ = 20;
    uint32_t rounds_ = 1;
    uint32_t neighbours_ = 3;
    float radius_ = 20;
    float normalThreshold_ = 0.5f;
    float depthThreshold_ = 0.1f;
    std::string fault_ = "none";
    Device* device_ = nullptr;
    Buffer scratch_[3];
    Kernel temporalKernel_, spatialKernel_, shadeKernel_;
};

}  // namespace restirpg

using restirpg::ReSTIRReuse;
RESTIRPG_PASS(ReSTIRReuse, "Resamples each pixel's path over frames and neighbouring pixels (ReSTIR PT)")
