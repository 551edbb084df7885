#include "Shared.h"
#include "graph/neighbour_knobs.h"
#include "render/frame.h"

namespace restirpg {

static_assert(sizeof(PathReservoir) == 88);

class ReSTIRReuse final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<PathReservoir>("PathReservoir");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel, through its centre");
        io.ofThisFrame();
        io.input("candidates", candidates_, reservoir, "this frame's candidate path, one per pixel");
        io.ofThisFrame();
        historyInputs(io, motion_, previousSurface_, history_, reservoir, "reuse.reservoirs");
        io.output("radiance", radiance_, image(3), "light of the chosen path, or of all merged paths, W/sr/m^2");
        io.output("reservoirs", reservoirs_, reservoir, "the path that each pixel keeps at the end of the frame");
        io.knob("temporal", temporal_, "merge with what the same surface kept in the frame before");
        io.knob("cap", cap_, 1, 1000,
                "largest confidence of the history, in multiples of the candidate's own (Lin et al. 2022: 20)");
        io.knob("rounds", rounds_, 0, 8, "rounds of spatial reuse; 0: none");
        neighbourKnobs(io, rules_, "pixels (or pairs)");
        io.knob("reciprocal", reciprocal_,
                "pair pixels, so that each shift serves both: half the shifts of spatial reuse");
        io.structural();
        io.choice(
            "shade", shadeMerged_, {{"chosen", false}, {"merged", true}},
            "light of a pixel: of the path that it keeps, as published, or of all paths that the last merge chose "
            "from, by their resampling weights, which has the same luminance and less noise of colour");
        diskKnobs(io, rules_);
        similarityKnobs(io, rules_);
    }

    void build(Device& device) override
    {
        temporalKernel_ = Kernel(device, passFile("Temporal.comp"), {}, {}, compileIf(temporal_ && history_));
        pairsKernel_ = Kernel(device, passFile("Pairs.comp"), {}, {}, compileIf(rounds_ > 0 && reciprocal_));
        imagesKernel_ = Kernel(device, passFile("Images.comp"), {}, {}, compileIf(rounds_ > 0 && reciprocal_));
        spatialKernel_ = Kernel(device, passFile("Spatial.comp"), {{"RECIPROCAL", reciprocal_ ? "1" : "0"}}, {},
                                compileIf(rounds_ > 0));
        shadeKernel_ = Kernel(device, passFile("Shade.comp"), {}, {}, compileIf(bool(radiance_)));
    }

    void record(Frame& frame) override
    {
        ReuseParameters parameters = makeParameters(frame);
        // Each stage reads one set of paths and writes another; the last one writes the output.
        uint32_t stage = rounds_;
        const bool temporal = temporal_ && history_ && !history_.empty;
        if (temporal) {
            setDestination(parameters, frame, stage);
            frame.dispatchPixels(temporalKernel_, parameters);
            takeAsSource(parameters);
        }
        for (parameters.round = 0; parameters.round < rounds_; ++parameters.round) {
            setDestination(parameters, frame, --stage);
            if (reciprocal_) {
                const uint64_t places = uint64_t(frame.width()) * frame.height() * rules_.neighbours;
                parameters.partners = frame.scratch(partners_, places * sizeof(uint32_t), "partners of pixels");
                parameters.images = frame.scratch(images_, places * sizeof(PathImage), "images of partners' paths");
                frame.dispatchPixels(pairsKernel_, parameters);
                frame.dispatchPixels(imagesKernel_, parameters);
            }
            frame.dispatchPixels(spatialKernel_, parameters);
            takeAsSource(parameters);
        }
        if (!temporal && rounds_ == 0 && reservoirs_)
            frame.copy(*candidates_.resource, *reservoirs_.resource);
        if (radiance_ && parameters.radiance == 0) {
            parameters.radiance = radiance_->address();
            frame.dispatchPixels(shadeKernel_, parameters);
        }
    }

private:
    ReuseParameters makeParameters(const Frame& frame) const
    {
        ReuseParameters p{};
        p.frame = frame.constants();
        p.surface = surface_->address();
        p.previousSurface = addressOf(previousSurface_);
        p.motion = addressOf(motion_);
        p.source = candidates_->address();
        p.history = addressOf(history_);
        p.cap = cap_;
        p.rules = rules_;
        return p;
    }

    /// Where a stage writes that still has `left` stages after it: the output for the last, else one of two buffers of
    /// our own.
    void setDestination(ReuseParameters& parameters, Frame& frame, uint32_t left)
    {
        constexpr const char* SCRATCH = "paths between two stages of reuse";
        const uint64_t pixels = uint64_t(frame.width()) * frame.height();
        const uint32_t own = left == 0 ? 2 : left % 2;
        parameters.reservoirs = left == 0 && reservoirs_
                                    ? reservoirs_->address()
                                    : frame.scratch(scratch_[own], pixels * sizeof(PathReservoir), SCRATCH);
        parameters.radiance = left == 0 && shadeMerged_ ? addressOf(radiance_) : 0;
    }

    static void takeAsSource(ReuseParameters& parameters) { parameters.source = parameters.reservoirs; }

    In<Buffer> surface_, candidates_, motion_, previousSurface_, history_;
    Out<Buffer> radiance_, reservoirs_;
    bool temporal_ = true;
    float cap_ = 20;
    uint32_t rounds_ = 1;
    NeighbourRules rules_{
        .neighbours = 3, .pool = 1, .radius = 20, .leastRadius = 3, .normalThreshold = 0.5f, .depthThreshold = 0.1f};
    bool reciprocal_ = false;
    bool shadeMerged_ = false;
    Buffer scratch_[3], images_, partners_;
    Kernel temporalKernel_, pairsKernel_, imagesKernel_, spatialKernel_, shadeKernel_;
};

}  // namespace restirpg

using restirpg::ReSTIRReuse;
RESTIRPG_PASS(ReSTIRReuse, "Resamples each pixel's path over frames and neighbouring pixels (ReSTIR PT)")
