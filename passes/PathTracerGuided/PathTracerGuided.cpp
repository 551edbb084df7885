#include "Shared.h"
#include "render/frame.h"

namespace restirpg {

class PathTracerGuided final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<Hit>("Surface"), "primary hit of each pixel");
        io.optionalInput("guide", guide_, guide({}, {}), "directions worth sampling, with the GLSL module of the pass that makes them; unwired: a plain path tracer");
        io.output("radiance", radiance_, image(3), "one path's estimate of the light scattered to the camera, W/sr/m^2, without emission of the primary hit");
        io.knob("bounces", bounces_, 0, 64, "bounce cap n: light reaches the camera over at most n + 2 edges (Zeng et al. 2025 counts so)");
        io.knob("nee", nee_, "connect every vertex to a light, weighted against scattering by the balance heuristic");
        io.knob("direct", direct_, "include direct light at the primary hit; off where ReSTIRDI owns it (through delta lobes it is always included)");
        io.knob("alpha", alpha_, 0, 1, "probability of sampling a smooth bounce by the BSDF instead of the guide, where there is guidance (Zeng et al. 2025: 0.5)");
    }

    void build(Device& device) override
    {
        const bool guided = !guide_.module.empty();
        kernel_ = Kernel(device, passFile("PathTracerGuided.comp"), {{"GUIDED", guided ? "1" : "0"}},
                         {{"guide_module.glsl", guide_.module}});
    }

    void record(Frame& frame) override
    {
        const PathTracerParameters parameters{
            frame.constants(), surface_->address(), addressOf(radiance_), addressOf(guide_), bounces_, nee_, direct_, alpha_};
        frame.dispatchPixels(kernel_, parameters);
    }

private:
    In<Buffer> surface_, guide_;
    Out<Buffer> radiance_;
    uint32_t bounces_ = 4;
    bool nee_ = true;
    bool direct_ = false;
    float alpha_ = 0.5f;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::PathTracerGuided;
RESTIRPG_PASS(PathTracerGuided, "Traces one path a pixel: next event estimation and BSDF sampling, weighted by the balance heuristic")
