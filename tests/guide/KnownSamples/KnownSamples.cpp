// Samples whose distribution is known: one per pixel, spread evenly over some places that lie in cells of their own.
#include "KnownSamplesShared.h"
#include "render/frame.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

class KnownSamples final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.output("samples", samples_, perPixel<GuidingSample>("GuidingSamples"),
                  "one sample per pixel, of weight 1, its direction drawn from the mixture of KnownSamples.comp");
        io.knob("places", places_, 1, 4096, "points at which the samples lie, in a square of 64 x 64");
        io.knob("identical", identical_, "all directions are the axis of the first lobe");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("KnownSamples.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(kernel_,
                             KnownSamplesParameters{frame.constants(), samples_->address(), places_, identical_});
    }

private:
    Out<Buffer> samples_;
    uint32_t places_ = 1;
    bool identical_ = false;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::KnownSamples;
RESTIRPG_PASS(KnownSamples, "A test's samples: directions of a known mixture")
