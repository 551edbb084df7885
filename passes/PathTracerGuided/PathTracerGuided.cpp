#include "Shared.h"
#include "render/frame.h"
#include "shaders/restir/path_reservoir_types.h"
#include "shaders/restir/path_vertex_types.h"

#include <algorithm>

namespace restirpg {

namespace {

/// The labels of a candidate's bounces have to fit its reservoir.
constexpr uint32_t MAX_CANDIDATE_BOUNCES = PATH_MAX_EDGES - 2;
/// The bits that the keys of random numbers have for a tree, see tree_key (random.glsl).
constexpr uint32_t MAX_TREES = 16;

}  // namespace

class PathTracerGuided final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.optionalInput(
            "guide", guide_, anyGuide(),
            "directions to sample, with the GLSL module of the pass that makes them; unwired: a plain path tracer");
        io.output("radiance", radiance_, image(3),
                  "estimate of the light scattered to the camera, by one path per tree, W/sr/m^2, without emission of "
                  "the primary hit");
        io.output("candidates", candidates_, perPixel<PathReservoir>("PathReservoir"),
                  "one path per pixel, resampled from all that end on the way of its path trees; without direct light "
                  "but what delta lobes find");
        io.output("samples", samples_,
                  severalPerPixel<GuidingSample>("GuidingSamples", [this] { return trees_ * guidedBounces(); }),
                  "the first guided_bounces bounces of the path trees, bounces + 1 at most, with the light that came "
                  "back along each");
        io.knob("bounces", bounces_, 0, 64,
                "bounce cap n: light reaches the camera over at most n + 2 path edges, as Zeng et al. 2025 count");
        io.structural();
        io.knob("nee", nee_,
                "connect every vertex to a light (next event estimation), combined with scattering by the balance "
                "heuristic");
        io.structural();
        io.knob("direct", direct_,
                "include direct light at the primary hit; off where ReSTIRDI computes it (light through delta lobes is "
                "always included)");
        io.structural();
        io.knob("alpha", alpha_, 0, 1,
                "probability of sampling a smooth bounce by the BSDF instead of the guide, where there is guidance "
                "(Zeng et al. 2025: 0.5)");
        io.knob("guided_bounces", guidedBounces_, 1, 64,
                "bounces from the primary hit on that the guide draws, and that `samples` has; later ones follow the "
                "BSDF");
        io.structural();
        io.knob("trees", trees_, 1, MAX_TREES,
                "path trees per pixel and frame, each a path of its own from the primary hit on");
        io.structural();
    }

    void check() const override
    {
        if (wantsTree() && bounces_ > MAX_CANDIDATE_BOUNCES)
            fail("with candidates or samples in use 'bounces' is at most {}, not {}; set it lower",
                 MAX_CANDIDATE_BOUNCES, bounces_);
    }

    void build(Device& device) override
    {
        const bool guided = !guide_.module.empty();
        const Defines defines = {{"GUIDED", guided ? "1" : "0"}, {"SAMPLES", samples_ ? "1" : "0"}};
        const Includes includes = {{"guide_module.glsl", guide_.module}};
        if (radiance_)
            kernel_ = Kernel(device, passFile("PathTracerGuided.comp"), defines, includes);
        if (wantsTree())
            treeKernel_ = Kernel(device, passFile("Candidates.comp"), defines, includes);
    }

    void record(Frame& frame) override
    {
        const PathTracerParameters parameters{frame.constants(),
                                              surface_->address(),
                                              addressOf(radiance_),
                                              addressOf(candidates_),
                                              addressOf(guide_),
                                              addressOf(samples_),
                                              bounces_,
                                              nee_,
                                              direct_,
                                              alpha_,
                                              trees_,
                                              guidedBounces()};
        if (radiance_)
            frame.dispatchPixels(kernel_, parameters);
        if (wantsTree())
            frame.dispatchPixels(treeKernel_, parameters);
    }

private:
    /// Does anybody read what a resampled path tree gives?
    bool wantsTree() const { return candidates_ || samples_; }

    uint32_t guidedBounces() const { return std::min(guidedBounces_, bounces_ + 1); }

    In<Buffer> surface_, guide_;
    Out<Buffer> radiance_, candidates_, samples_;
    uint32_t bounces_ = 4;
    bool nee_ = true;
    bool direct_ = false;
    float alpha_ = 0.5f;
    uint32_t guidedBounces_ = 64;
    uint32_t trees_ = 1;
    Kernel kernel_, treeKernel_;
};

}  // namespace restirpg

using restirpg::PathTracerGuided;
RESTIRPG_PASS(
    PathTracerGuided,
    "Traces paths from each pixel: next event estimation and BSDF sampling, weighted by the balance heuristic")
