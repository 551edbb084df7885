#include "Shared.h"
#include "render/frame.h"

#include <cmath>

namespace restirpg {

class ToneMap final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("image", image_, image(3), "radiance, linear Rec.709");
        io.output("display", display_, image(3), "sRGB, encoded, 0 to 1");
        io.knob("exposure", exposure_, -20, 20, "stops: radiance is multiplied by 2 to this power");
        io.choice("curve", curve_, {{"linear", TONE_CURVE_LINEAR}, {"reinhard", TONE_CURVE_REINHARD}},
                  "linear: clip at 1; reinhard: compress the luminance (Reinhard et al. 2002)");
        io.knob("white", white_, 0.1f, 1000, "luminance after exposure that reinhard maps to 1");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("ToneMap.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(kernel_, ToneMapParameters{frame.constants(), image_->address(), display_->address(),
                                                        std::exp2(exposure_), white_, curve_});
    }

private:
    In<Buffer> image_;
    Out<Buffer> display_;
    float exposure_ = 0;
    uint32_t curve_ = TONE_CURVE_LINEAR;
    float white_ = 4;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::ToneMap;
RESTIRPG_PASS(ToneMap, "Makes radiance displayable: exposure, tone curve, sRGB encoding")
