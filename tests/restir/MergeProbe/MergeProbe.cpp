// Measures the MIS weights of ReSTIRDI's merges, with the participants, targets and weights of its own GLSL.
#include "../../../passes/ReSTIRDI/Shared.h"
#include "render/frame.h"

namespace restirpg {

class MergeProbe final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<LightReservoir>("LightReservoir");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.input("previous_surface", previousSurface_, perPixel<PrimaryHit>("Surface"), "the same, one frame ago");
        io.input("motion", motion_, motionVectors(), "motion vectors");
        io.input("reservoirs", reservoirs_, reservoir, "reservoirs of this frame");
        io.input("history", history_, reservoir, "reservoirs of the frame before");
        const std::string meaning =
            "farthest from 1 that the weights of one point add up to, and how many points were tried: ";
        io.output("temporal", temporal_, image(2), meaning + "temporal reuse");
        io.output("spatial", spatial_, image(2), meaning + "spatial reuse");
        io.knob("pairwise", pairwise_, "weights of spatial reuse");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("MergeProbe.comp")); }

    void record(Frame& frame) override
    {
        ReSTIRDIParameters parameters{};
        parameters.frame = frame.constants();
        parameters.surface = surface_->address();
        parameters.previousSurface = previousSurface_->address();
        parameters.motion = motion_->address();
        parameters.history = history_->address();
        parameters.source = reservoirs_->address();
        parameters.cap = 5;
        parameters.rules = {
            .neighbours = 4, .pool = 1, .radius = 0, .leastRadius = 4, .normalThreshold = 0.5f, .depthThreshold = 0.1f};
        parameters.radiance = temporal_->address();
        frame.dispatchPixels(kernel_, parameters);
        parameters.radiance = spatial_->address();
        parameters.round = 1;
        parameters.pairwise = pairwise_;
        frame.dispatchPixels(kernel_, parameters);
    }

private:
    In<Buffer> surface_, previousSurface_, motion_, reservoirs_, history_;
    Out<Buffer> temporal_, spatial_;
    bool pairwise_ = true;
    Kernel kernel_;
};

RESTIRPG_PASS(MergeProbe, "Adds up the MIS weights of ReSTIRDI's merges")

}  // namespace restirpg
