#include "Shared.h"
#include "graph/grid_knobs.h"
#include "render/frame.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

static_assert(sizeof(ChainHeader) <= GUIDING_HEADER_BYTES);

class GuidingChain final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType layout = guide("ChainGuide", fixedSize("", [this] { return bytes(); }), passFile("guide.glsl"));
        io.input("samples", samples_, anyPerPixel("GuidingSamples"),
                 "bounces of raw path trees, weighted by the light that came back: paths.samples");
        io.ofThisFrame();
        io.input("history", history_, layout, "the output guide, one frame ago: prev(\"guide.guide\")");
        io.ofFrameBefore();
        io.output("guide", guide_, layout,
                  "four von Mises-Fisher lobes per cell, from which the next frame's paths are sampled");
        cellsKnob(io, cells_);
        cellSizeKnobs(io, cellSize_, smallestCell_);
        io.knob("product", product_, "follow the incident radiance times BSDF and cosine; off: the radiance alone");
        io.structural();
        io.knob(
            "spread", spread_, 0, 4,
            "side of the square around a bounce from which the cell that guides it is taken, in sides of a cell; 0: "
            "its own cell");
        io.knob("decay", decay_, 0, 1,
                "factor by which the light that a chain has found counts in the next frame: below 1, a chain leaves "
                "even the brightest sample in the end");
        io.knob("memory", memory_, 1, 65536,
                "largest number of samples that a lobe's means average; further samples enter with the weight "
                "1 / memory");
        io.knob("concentration_prior", prior_, 0, 1000,
                "keeps lobes of few samples wide, in square metres: a larger value makes them wider");
        io.knob("largest_kappa", largestKappa_, 1, 32000, "largest concentration (kappa) of a lobe");
        io.knob("oldest", oldest_, 0, 10000, "frames for which a cell goes on guiding when no path reaches it");
    }

    void build(Device& device) override
    {
        proposeKernel_ = Kernel(device, passFile("Propose.comp"));
        advanceKernel_ = Kernel(device, passFile("Advance.comp"));
        carryKernel_ = Kernel(device, passFile("Carry.comp"));
        proposals_ = device.createBuffer(uint64_t(capacity()) * sizeof(ChainProposals), "proposals to Markov chains");
    }

    void record(Frame& frame) override
    {
        const uint32_t stride = samples_.countPerPixel<GuidingSample>();
        // A proposal is its sample's number and one bit more, in 32 bits (ChainProposals).
        constexpr uint64_t MOST_SAMPLES = (1ull << 31) - 1;
        const uint64_t samples = uint64_t(frame.width()) * frame.height() * stride;
        if (samples > MOST_SAMPLES)
            fail("'samples' has {} bounces at {}x{} pixels, of which chains can count {}; lower guided_bounces or "
                 "trees of the pass that traces them, or render a window",
                 samples, frame.width(), frame.height(), MOST_SAMPLES);
        const GuidingChainParameters parameters{frame.constants(),
                                                samples_->address(),
                                                history_.empty ? 0 : history_->address(),
                                                guide_->address(),
                                                proposals_.address(),
                                                stride,
                                                capacity(),
                                                product_,
                                                oldest_,
                                                cellSize_,
                                                smallestCell_,
                                                spread_,
                                                decay_,
                                                memory_,
                                                prior_,
                                                largestKappa_};
        frame.fill(*guide_.resource, 0, gridBytes(capacity()));
        frame.fill(proposals_);
        frame.dispatch(proposeKernel_, parameters, frame.width(), frame.height(), stride);
        frame.dispatch(advanceKernel_, parameters, capacity());
        if (parameters.history != 0)
            frame.dispatch(carryKernel_, parameters, capacity());
    }

private:
    uint32_t capacity() const { return gridCapacity(cells_); }

    uint64_t bytes() const { return gridBytes(capacity(), sizeof(ChainCell)); }

    In<Buffer> samples_, history_;
    Out<Buffer> guide_;
    uint32_t cells_ = 1u << 16;
    float cellSize_ = 0.25f;
    float smallestCell_ = 1e-3f;
    bool product_ = true;
    float spread_ = 1;
    float decay_ = 0.9f;
    float memory_ = 1024;
    float prior_ = 1;
    float largestKappa_ = 32000;
    uint32_t oldest_ = 16;
    Buffer proposals_;
    Kernel proposeKernel_, advanceKernel_, carryKernel_;
};

}  // namespace restirpg

using restirpg::GuidingChain;
RESTIRPG_PASS(GuidingChain,
              "Moves the Markov chains of each cell of the guiding grid: each chain is a lobe that guides")
