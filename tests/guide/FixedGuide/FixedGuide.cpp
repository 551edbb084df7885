// A guide that knows nothing: one von Mises-Fisher lobe, everywhere the same. Any guide must leave the mean as it is.
#include "FixedGuideShared.h"
#include "render/frame.h"

namespace restirpg {

class FixedGuide final : public Pass {
public:
    void describe(Interface& io) override
    {
        const auto layout = fixedSize("", [] { return sizeof(FixedGuideLobe); });
        io.output("guide", guide_, guide("FixedGuide", layout, passFile("guide.glsl")), "the lobe");
        io.output("wrong", wrong_, guide("WrongFixedGuide", layout, passFile("wrong_guide.glsl")),
                  "the lobe, with a density that is 10% too small");
        io.knob("kappa", kappa_, 0, 32000, "concentration of the lobe, which points up");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("FixedGuide.comp")); }

    void record(Frame& frame) override
    {
        for (const auto* port : {&guide_, &wrong_})
            if (*port)
                frame.dispatch(kernel_, FixedGuideParameters{(*port)->address(), kappa_}, 1);
    }

private:
    Out<Buffer> guide_, wrong_;
    float kappa_ = 2;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::FixedGuide;
RESTIRPG_PASS(FixedGuide, "A test's guide: one lobe for every place")
