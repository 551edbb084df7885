#include "Shared.h"
#include "render/frame.h"
#include "shaders/path_reservoir_types.h"
#include "shaders/path_vertex_types.h"

#include <algorithm>

namespace restirpg {

namespace {

/// The labels of a candidate's bounces have to fit its reservoir.
constexpr uint32_t MAX_CANDIDATE_BOUNCES = PATH_MAX_EDGES - 2;
/// In the order of TREE_FAULT_*.
const std::vector<std::string> FAULTS = {"none", "label_probability", "light_measure", "found_lights"};

}  // namespace

class PathTracerGuided final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.optionalInput("guide", guide_, anyGuide(), "directions to sample, with the GLSL module of the pass that makes them; unwired: a plain path tracer");
        io.output("radiance", radiance_, image(3), "one path's estimate of the light scattered to the camera, W/sr/m^2, without emission of the primary hit");
        io.output("candidates", candidates_, perPixel<PathReservoir>("PathReservoir"),
                  "one path a pixel, resampled from all that end on the way of a path tree; without direct light but what delta lobes find");
        const auto stride = [this] { return bounces_ + 1; };
        io.output("vertices", vertices_, severalPerPixel<PathVertex>("PathVertices", stride), "the bounces of the candidate path, bounces + 1 a pixel");
        io.output("samples", samples_, severalPerPixel<GuidingSample>("GuidingSamples", stride),
                  "all bounces of the candidate's path tree with the light that came back along each, bounces + 1 a pixel");
        io.knob("bounces", bounces_, 0, 64, "bounce cap n: light reaches the camera over at most n + 2 path edges, as Zeng et al. 2025 count");
        io.structural();
        io.knob("nee", nee_, "connect every vertex to a light (next event estimation), combined with scattering by the balance heuristic");
        io.knob("direct", direct_, "include direct light at the primary hit; off where ReSTIRDI computes it (light through delta lobes is always included)");
        io.knob("alpha", alpha_, 0, 1, "probability of sampling a smooth bounce by the BSDF instead of the guide, where there is guidance (Zeng et al. 2025: 0.5)");
        io.choice("fault", fault_, FAULTS, "for tests only: build this mistake into the candidates");
        io.structural();
    }

    void check() const override
    {
        if (wantsTree() && bounces_ > MAX_CANDIDATE_BOUNCES)
            fail("candidates hold paths of at most {} bounces, 'bounces' is {}; set it lower", MAX_CANDIDATE_BOUNCES, bounces_);
    }

    void build(Device& device) override
    {
        const bool guided = !guide_.module.empty();
        const Defines defines = {{"GUIDED", guided ? "1" : "0"}, {"VERTICES", vertices_ ? "1" : "0"}, {"SAMPLES", samples_ ? "1" : "0"}};
        const Includes includes = {{"guide_module.glsl", guide_.module}};
        const auto fault = std::find(FAULTS.begin(), FAULTS.end(), fault_) - FAULTS.begin();
        Defines treeDefines = defines;
        treeDefines["RESTIRPG_FAULT"] = std::to_string(fault) + "u";
        if (radiance_)
            kernel_ = Kernel(device, passFile("PathTracerGuided.comp"), defines, includes);
        if (wantsTree())
            treeKernel_ = Kernel(device, passFile("Candidates.comp"), treeDefines, includes);
    }

    void record(Frame& frame) override
    {
        const PathTracerParameters parameters{frame.constants(),
                                              surface_->address(),
                                              addressOf(radiance_),
                                              addressOf(candidates_),
                                              addressOf(guide_),
                                              addressOf(vertices_),
                                              addressOf(samples_),
                                              bounces_,
                                              nee_,
                                              direct_,
                                              alpha_};
        if (radiance_)
            frame.dispatchPixels(kernel_, parameters);
        if (wantsTree())
            frame.dispatchPixels(treeKernel_, parameters);
    }

private:
    /// Does anybody read what a resampled path tree gives?
    bool wantsTree() const { return candidates_ || vertices_ || samples_; }

    In<Buffer> surface_, guide_;
    Out<Buffer> radiance_, candidates_, vertices_, samples_;
    uint32_t bounces_ = 4;
    bool nee_ = true;
    bool direct_ = false;
    float alpha_ = 0.5f;
    std::string fault_ = "none";
    Kernel kernel_, treeKernel_;
};

}  // namespace restirpg

using restirpg::PathTracerGuided;
RESTIRPG_PASS(PathTracerGuided, "Traces one path a pixel: next event estimation and BSDF sampling, weighted by the balance heuristic")
