#include "Shared.h"
#include "render/frame.h"

#include <array>

namespace restirpg {

static_assert(sizeof(LightReservoir) == 28);

class ReSTIRDI final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<LightReservoir>("LightReservoir");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel, through its centre");
        io.ofThisFrame();
        io.optionalInput("motion", motion_, motionVectors(),
                         "where the point was in the frame before, minus where it is, in pixels");
        io.ofThisFrame();
        io.optionalInput("previous_surface", previousSurface_, perPixel<PrimaryHit>("Surface"),
                         "the surface one frame ago: prev(\"gbuffer.surface\")");
        io.ofFrameBefore();
        io.optionalInput("history", history_, reservoir,
                         "the output reservoirs, one frame ago: prev(\"direct.reservoirs\")");
        io.ofFrameBefore();
        io.together({"motion", "previous_surface", "history"});
        io.output("radiance", radiance_, image(3),
                  "direct light scattered to the camera through lobes that are not deltas, W/sr/m^2");
        io.output("reservoirs", reservoirs_, reservoir,
                  "the light point that each pixel keeps at the end of the frame");
        io.knob("candidates", candidates_, 1, 1024, "light points drawn per pixel");
        io.knob("bsdf_candidates", bsdfCandidates_, 0, 16, "light points found by scattering, per pixel");
        io.knob("temporal", temporal_, "merge with what the same surface kept in the frame before");
        io.knob("cap", cap_, 1, 1000, "largest confidence of the history, in sets of candidates");
        io.knob("rounds", rounds_, 0, 8, "rounds of spatial reuse; 0: none");
        io.knob("neighbours", rules_.neighbours, 1, MAX_NEIGHBOURS, "pixels drawn in one round");
        io.knob("pool", rules_.pool, 1, MAX_POOL,
                "pixels that each neighbour is chosen from, by how much its surface is like this pixel's; 1: the one "
                "that is drawn, as published");
        io.choice(
            "shade", shadeMerged_, {{"chosen", false}, {"merged", true}},
            "light of a pixel: of the point that it keeps, as published, or of all points that the last merge chose "
            "from, by their resampling weights, which has the same luminance and less noise of colour");
        io.knob("radius", rules_.radius, 1, 1000,
                "radius of the disk from which neighbours are drawn, in pixels of an image of 1080 lines; it scales "
                "with the image's height, down to least_radius");
        io.knob("least_radius", rules_.leastRadius, 1, 1000,
                "least radius of the disk, in pixels of the rendered image");
        io.choice("mis", pairwise_, {{"pairwise", true}, {"balance", false}},
                  "MIS weights of spatial reuse with n neighbours: pairwise takes 2 n shadow rays, balance n (n + 1)");
        io.knob("feedback", feedback_,
                "the next frame starts from the reservoirs after spatial reuse; off: from those before");
        io.knob("normal_threshold", rules_.normalThreshold, -1, 1,
                "smallest cosine between the shading normals of pixels that are merged");
        io.knob("depth_threshold", rules_.depthThreshold, 0, 1000,
                "largest relative difference of their distances from the camera");
    }

    void build(Device& device) override
    {
        device_ = &device;
        candidatesKernel_ = Kernel(device, passFile("Candidates.comp"));
        temporalKernel_ = Kernel(device, passFile("Temporal.comp"), {}, {}, compileIf(temporal_ && history_));
        spatialKernel_ = Kernel(device, passFile("Spatial.comp"), {}, {}, compileIf(rounds_ > 0));
        shadeKernel_ = Kernel(device, passFile("Shade.comp"), {}, {}, compileIf(bool(radiance_)));
    }

    void record(Frame& frame) override
    {
        ReSTIRDIParameters parameters = parametersOf(frame);
        parameters.reservoirs = stageTarget(frame, 0);
        frame.dispatchPixels(candidatesKernel_, parameters);
        const Address shaded = shadeMerged_ ? addressOf(radiance_) : 0;
        if (temporal_ && history_ && !history_.empty) {
            parameters.radiance = rounds_ == 0 ? shaded : 0;
            frame.dispatchPixels(temporalKernel_, parameters);
        }
        for (parameters.round = 0; parameters.round < rounds_; ++parameters.round) {
            parameters.source = parameters.reservoirs;
            parameters.reservoirs = stageTarget(frame, parameters.round + 1);
            parameters.radiance = parameters.round + 1 == rounds_ ? shaded : 0;
            frame.dispatchPixels(spatialKernel_, parameters);
        }
        parameters.source = parameters.reservoirs;
        if (radiance_ && parameters.radiance == 0) {
            parameters.radiance = radiance_->address();
            frame.dispatchPixels(shadeKernel_, parameters);
        }
    }

private:
    ReSTIRDIParameters parametersOf(const Frame& frame) const
    {
        ReSTIRDIParameters parameters{};
        parameters.frame = frame.constants();
        parameters.surface = surface_->address();
        parameters.previousSurface = addressOf(previousSurface_);
        parameters.motion = addressOf(motion_);
        parameters.history = addressOf(history_);
        parameters.candidates = candidates_;
        parameters.bsdfCandidates = bsdfCandidates_;
        parameters.pairwise = pairwise_;
        parameters.cap = float(cap_);
        parameters.rules = rules_;
        return parameters;
    }

    /// A buffer of the pass's own of one reservoir per pixel, of this frame's size.
    Address scratch(const Frame& frame, size_t index)
    {
        const uint64_t bytes = sizeof(LightReservoir) * uint64_t(frame.width()) * frame.height();
        if (!scratch_[index] || scratch_[index].bytes() != bytes)
            scratch_[index] = device_->createBuffer(bytes, "ReSTIRDI scratch");
        return scratch_[index].address();
    }

    /// Where a stage leaves its reservoirs, never where it reads them: stage 0 is candidates and temporal reuse, stage
    /// r the r-th spatial round. The stage that the next frame starts from ends in the output.
    Address stageTarget(const Frame& frame, uint32_t stage)
    {
        const bool even = (rounds_ - stage) % 2 == 0;
        const bool handedOn = feedback_ ? even : stage == 0;
        if (handedOn)
            return reservoirs_ ? reservoirs_->address() : scratch(frame, 0);
        return scratch(frame, even ? 2 : 1);
    }

    In<Buffer> surface_, motion_, previousSurface_, history_;
    Out<Buffer> radiance_, reservoirs_;
    uint32_t candidates_ = 32;
    uint32_t bsdfCandidates_ = 1;
    bool temporal_ = true;
    uint32_t cap_ = 20;
    uint32_t rounds_ = 1;
    NeighbourRules rules_{
        .neighbours = 5, .pool = 1, .radius = 30, .leastRadius = 3, .normalThreshold = 0.5f, .depthThreshold = 0.1f};
    bool feedback_ = true;
    bool pairwise_ = true;
    bool shadeMerged_ = false;
    Device* device_ = nullptr;
    Kernel candidatesKernel_, temporalKernel_, spatialKernel_, shadeKernel_;
    std::array<Buffer, 3> scratch_;
};

RESTIRPG_PASS(ReSTIRDI,
              "Direct light by resampling light points over candidates, frames and neighbouring pixels, without bias")

}  // namespace restirpg
