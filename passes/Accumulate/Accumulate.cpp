// Mean and variance of a pixel over the frames since the last cut.
#include "Shared.h"

#include "render/frame.h"

namespace restirpg {

static_assert(sizeof(AccumulatorState) == 56);
static_assert(sizeof(AccumulateParameters) == 10 * sizeof(Address));

class Accumulate final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType state = perPixel<AccumulatorState>("AccumulatorState");
        io.optionalInput("direct", direct_, image(3), "radiance of this frame, linear Rec.709");
        io.optionalInput("indirect", indirect_, image(3), "radiance to add to it");
        io.optionalInput("emission", emission_, image(3), "radiance to add to it");
        io.input("history", history_, state, "the output sums, one frame ago: prev(\"accumulate.sums\")");
        io.ofFrameBefore();
        io.output("sums", sums_, state, "sums and counts of the frames since the last cut");
        io.output("frame", value_, image(3), "this frame alone: the sum of the inputs");
        io.output("mean", mean_, image(3), "mean over the valid frames; 0 where there is none");
        io.output("variance", variance_, image(3),
                  "unbiased sample variance of a frame's value (that of the mean is 1/frames of it); 0 before the "
                  "second frame");
        io.output("invalid", invalid_, image(1), "frames left out at the pixel: NaN, infinite or beyond 1e30");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("Accumulate.comp")); }

    void record(Frame& frame) override
    {
        const AccumulateParameters parameters{
            frame.constants(), addressOf(direct_), addressOf(indirect_), addressOf(emission_), addressOf(history_),
            addressOf(sums_),  addressOf(value_),  addressOf(mean_),     addressOf(variance_), addressOf(invalid_)};
        frame.dispatchPixels(kernel_, parameters);
    }

private:
    In<Buffer> direct_, indirect_, emission_, history_;
    Out<Buffer> sums_, value_, mean_, variance_, invalid_;
    Kernel kernel_;
};

RESTIRPG_PASS(Accumulate, "Averages the frames since the last cut, with the variance of a frame")

}  // namespace restirpg
