#include "Shared.h"
#include "graph/grid_knobs.h"
#include "render/frame.h"

namespace restirpg {

class GuidingFit final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType layout = guide("GridGuide", fixedSize("", [this] { return bytes(); }), passFile("guide.glsl"));
        io.input("statistics", statistics_,
                 // What GuidingSplat with the same knobs makes.
                 fixedSize("GuidingStatistics", [this] { return gridStatisticsBytes(capacity(), parallax_); }),
                 "GuidingSplat's sums of this frame");
        io.ofThisFrame();
        io.input("history", history_, layout, "the output guide, one frame ago: prev(\"fit.guide\")");
        io.ofFrameBefore();
        io.output(
            "guide", guide_, layout,
            "a mixture of up to four von Mises-Fisher lobes per cell, from which the next frame's paths are sampled");
        cellsKnob(io, cells_, "; GuidingSplat's must be the same");
        io.knob("minimum", minimum_, 1, 1e6f, "a cell with fewer samples than this is not fitted");
        io.knob("keep_samples", keepSamples_,
                "a cell with fewer than `minimum` samples keeps them for the next frame; off: it drops them and keeps "
                "its lobes");
        io.structural();
        io.knob(
            "decay", decay_, 0, 0.999f,
            "factor by which a cell's sums count in the next frame's fit; 0: they are forgotten (Zeng et al. 2025: 0)");
        io.structural();
        io.knob("oldest", oldest_, 0, 10000, "frames for which a cell goes on guiding without being fitted again");
        io.knob("lobes", lobes_, 1, GUIDING_LOBES, "number of lobes in a cell's mixture (Zeng et al. 2025: 4)");
        io.knob("weight_prior", weightPrior_, 0, 1000,
                "samples that are added to the count of each lobe: a larger value keeps the weights more even");
        io.knob("concentration_prior", concentrationPrior_, 0, 1000,
                "samples without a preferred direction that are added to each lobe: a larger value makes narrow lobes "
                "wider");
        io.knob("largest_kappa", largestKappa_, 1, 32000, "largest concentration (kappa) of a lobe");
        io.knob("reseed", reseed_, "move a lobe that no sample belongs to, to the sample that the mixture fits worst");
        io.knob("cosine", cosine_,
                "multiply the lobes by the cosine when they are read; use it with GuidingSplat's `incident`, whose "
                "lobes lack the cosine");
        io.knob("learn_alpha", learnAlpha_,
                "each cell learns alpha, the probability of sampling the BSDF; off: alpha is the tracing pass's");
        io.knob("alpha_prior", alphaPrior_, 0, 1000,
                "samples of the BSDF and of the guide that are added to a cell's own, where learn_alpha is on: a "
                "larger value keeps alpha nearer to 0.5");
        io.knob("parallax", parallax_,
                "aim each lobe at the mean distance of what its samples hit; needs GuidingSplat's `parallax`, and a "
                "`decay`");
        io.structural();
    }

    void check() const override
    {
        // A cell's memory holds what is left of its sums after a fit: nothing without decay.
        if (parallax_ && decay_ == 0)
            fail("'parallax' reads the distances that 'decay' keeps; set decay above 0, or parallax off");
    }

    void build(Device& device) override
    {
        fitKernel_ = Kernel(device, passFile("Fit.comp"));
        carryKernel_ = Kernel(device, passFile("Carry.comp"));
    }

    void record(Frame& frame) override
    {
        const GuidingFitParameters parameters{frame.constants(),
                                              statistics_->address(),
                                              history_.empty ? 0 : history_->address(),
                                              guide_->address(),
                                              capacity(),
                                              options(),
                                              remembers(),
                                              keepSamples_,
                                              reseed_,
                                              oldest_,
                                              lobes_,
                                              decay_,
                                              minimum_,
                                              alphaPrior_,
                                              weightPrior_,
                                              concentrationPrior_,
                                              largestKappa_};
        frame.fill(*guide_.resource, 0, gridBytes(capacity()));
        frame.dispatch(fitKernel_, parameters, capacity());
        if (parameters.history != 0)
            frame.dispatch(carryKernel_, parameters, capacity());
    }

private:
    uint32_t capacity() const { return gridCapacity(cells_); }

    uint32_t options() const
    {
        return (cosine_ ? GUIDING_COSINE : 0) | (parallax_ ? GUIDING_PARALLAX : 0) | (learnAlpha_ ? GUIDING_ALPHA : 0);
    }

    /// Parallax reads its sums at lookup.
    bool remembers() const { return keepSamples_ || decay_ > 0 || parallax_; }

    uint64_t bytes() const
    {
        return gridBytes(capacity(), GUIDING_CELL_BYTES + (remembers() ? GUIDING_MEMORY_BYTES : 0));
    }

    In<Buffer> statistics_, history_;
    Out<Buffer> guide_;
    uint32_t cells_ = 1u << 16;
    float minimum_ = 16;
    bool keepSamples_ = true;
    float decay_ = 0;
    uint32_t oldest_ = 16;
    uint32_t lobes_ = GUIDING_LOBES;
    bool learnAlpha_ = false;
    float alphaPrior_ = 8;
    float weightPrior_ = 0.1f;
    float concentrationPrior_ = 1;
    float largestKappa_ = 32000;
    bool reseed_ = true;
    bool cosine_ = false;
    bool parallax_ = false;
    Kernel fitKernel_, carryKernel_;
};

}  // namespace restirpg

using restirpg::GuidingFit;
RESTIRPG_PASS(GuidingFit, "Fits a mixture of directions to each cell of the guiding grid: one step of EM per frame")
