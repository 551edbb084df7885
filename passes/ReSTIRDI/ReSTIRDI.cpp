#include "Shared.h"
#include "graph/neighbour_knobs.h"
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
        historyInputs(io, motion_, previousSurface_, history_, reservoir, "direct.reservoirs");
        io.output("radiance", radiance_, image(3),
                  "direct light scattered to the camera through lobes that are not deltas, W/sr/m^2");
        io.output("reservoirs", reservoirs_, reservoir,
                  "the light point that each pixel keeps at the end of the frame");
        io.knob("candidates", candidates_, 1, 1024, "light points drawn per pixel");
        io.knob("bsdf_candidates", bsdfCandidates_, 0, 16, "light points found by scattering, per pixel");
        io.knob("temporal", temporal_, "merge with what the same surface kept in the frame before");
        io.knob("cap", cap_, 1, 1000, "largest confidence of the history, in sets of candidates");
        io.knob("rounds", rounds_, 0, 8, "rounds of spatial reuse; 0: none");
        neighbourKnobs(io, rules_, "pixels");
        io.choice(
            "shade", shadeMerged_, {{"chosen", false}, {"merged", true}},
            "light of a pixel: of the point that it keeps, as published, or of all points that the last merge chose "
            "from, by their resampling weights, which has the same luminance and less noise of colour");
        diskKnobs(io, rules_);
        io.choice("mis", pairwise_, {{"pairwise", true}, {"balance", false}},
                  "MIS weights of spatial reuse with n neighbours: pairwise takes 2 n shadow rays, balance n (n + 1)");
        io.knob("feedback", feedback_,
                "the next frame starts from the reservoirs after spatial reuse; off: from those before");
        similarityKnobs(io, rules_);
    }

    void build(Device& device) override
    {
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

    /// Where a stage leaves its reservoirs, never where it reads them: stage 0 is candidates and temporal reuse, stage
    /// r the r-th spatial round. The stage that the next frame starts from ends in the output.
    Address stageTarget(Frame& frame, uint32_t stage)
    {
        const uint64_t bytes = sizeof(LightReservoir) * uint64_t(frame.width()) * frame.height();
        const bool even = (rounds_ - stage) % 2 == 0;
        const bool handedOn = feedback_ ? even : stage == 0;
        if (handedOn && reservoirs_)
            return reservoirs_->address();
        return frame.scratch(scratch_[handedOn ? 0 : even ? 2 : 1], bytes, "light points between two stages of reuse");
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
    Kernel candidatesKernel_, temporalKernel_, spatialKernel_, shadeKernel_;
    std::array<Buffer, 3> scratch_;
};

RESTIRPG_PASS(ReSTIRDI,
              "Direct light by resampling light points over candidates, frames and neighbouring pixels, without bias")

}  // namespace restirpg
