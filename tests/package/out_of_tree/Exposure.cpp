#include "Shared.h"
#include "render/frame.h"

#include <cmath>

using namespace restirpg;

class Exposure final : public Pass {
    In<Buffer> radiance_;
    Out<Buffer> image_;
    float stops_ = 0;
    Kernel kernel_;

public:
    void describe(Interface& io) override
    {
        io.input("radiance", radiance_, image(3), "Linear radiance");
        io.output("image", image_, image(3), "The same, brighter by 2 to the power of `stops`");
        io.knob("stops", stops_, -20.0f, 20.0f, "Exposure in stops");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("Exposure.comp")); }

    void record(Frame& frame) override
    {
        const ExposureParams params{
            radiance_->address(), image_->address(), {frame.width(), frame.height()}, std::exp2(stops_)};
        frame.dispatchPixels(kernel_, params);
    }
};

RESTIRPG_PASS(Exposure, "Multiplies an image by a power of two")
