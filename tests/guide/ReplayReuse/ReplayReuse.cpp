// Direct light by one guided bounce with temporal reuse, whose sample is a direction (variant U) or random numbers
// (variant P).
#include "Shared.h"
#include "render/frame.h"

namespace restirpg {

class ReplayReuse final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<ReplayReservoir>("ReplayReservoir");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.optionalInput("guide", guide_, anyGuide(), "directions worth sampling");
        io.optionalInput("history", history_, reservoir,
                         "the output reservoirs, one frame ago; the camera must stand still");
        io.output("radiance", radiance_, image(3), "light by one bounce, W/sr/m^2");
        io.output("reservoirs", reservoirs_, reservoir, "the sample that each pixel ends the frame with");
        io.output("samples", samples_, perPixel<GuidingSample>("GuidingSamples"), "its bounce, of weight 1");
        io.knob("alpha", alpha_, 0, 1, "probability of the BSDF instead of the guide");
        io.knob("cap", cap_, 1, 1000, "of the history's confidence");
        io.knob("replay", replay_, "variant P: carry the random numbers; else variant U: carry the direction");
    }

    void build(Device& device) override
    {
        const Defines defines = {{"GUIDED", guide_.module.empty() ? "0" : "1"}};
        kernel_ = Kernel(device, passFile("ReplayReuse.comp"), defines, {{"guide_module.glsl", guide_.module}});
    }

    void record(Frame& frame) override
    {
        const bool past = history_ && !history_.empty;
        const ReplayParameters parameters{frame.constants(),
                                          surface_->address(),
                                          addressOf(guide_),
                                          past ? history_->address() : 0,
                                          addressOf(reservoirs_),
                                          addressOf(samples_),
                                          radiance_->address(),
                                          alpha_,
                                          cap_,
                                          replay_};
        frame.dispatchPixels(kernel_, parameters);
    }

private:
    In<Buffer> surface_, guide_, history_;
    Out<Buffer> radiance_, reservoirs_, samples_;
    float alpha_ = 0.5f;
    float cap_ = 8;
    bool replay_ = false;
    Kernel kernel_;
};

RESTIRPG_PASS(ReplayReuse, "Direct light by one guided bounce under temporal reuse, copied or replayed")

}  // namespace restirpg
