#include "Shared.h"
#include "render/frame.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

static_assert(sizeof(ScreenStatistics) == 36);
static_assert(sizeof(ScreenLobe) == 24);

class GuidingScreen final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType statistics = perPixel<ScreenStatistics>("ScreenStatistics");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.input("motion", motion_, motionVectors(),
                 "where the point was in the frame before, minus where it is, in pixels");
        io.ofThisFrame();
        io.input("previous_surface", previousSurface_, perPixel<PrimaryHit>("Surface"),
                 "the surface one frame ago: prev(\"gbuffer.surface\")");
        io.ofFrameBefore();
        io.input(
            "samples", samples_, anyPerPixel("GuidingSamples"),
            "directions that paths took, weighted by the light they found, one frame ago: prev(\"paths.samples\")");
        io.ofFrameBefore();
        io.input("history", history_, statistics, "the output statistics, one frame ago: prev(\"guide.statistics\")");
        io.ofFrameBefore();
        io.output("guide", guide_, guide("ScreenGuide", perPixel<ScreenLobe>(""), passFile("guide.glsl")),
                  "one lobe per pixel, for the bounce at the primary hit");
        io.output("statistics", statistics_, statistics, "weighted moments of the directions that each pixel has seen");
        io.output("direction", direction_, image(3),
                  "the lobe's mean direction as a colour, (1 + xyz) / 2; black where there is no lobe");
        io.output("peak", peak_, image(1), "the lobe's density at its mean direction, 1/sr");
        io.choice("lobe", lobe_, {{"gaussian", SCREEN_LOBE_GAUSSIAN}, {"vmf", SCREEN_LOBE_VMF}},
                  "a Gaussian in the equal-area square of the hemisphere about the normal, or a von Mises-Fisher lobe");
        io.structural();
        io.knob("product", product_, "fit the incident radiance times BSDF and cosine; off: the radiance alone");
        io.structural();
        io.knob("smoothing_floor", smoothingFloor_, 0.001f, 1,
                "smallest share that a new sample has in the moments; before it is reached, they are plain means");
        io.knob("neighbours", neighbours_, 0, SCREEN_NEIGHBOURS,
                "random pixels of the 5x5 window around this one whose last sample is used, too");
        io.knob(
            "prior", prior_, 0, 1000,
            "samples, spread evenly over the hemisphere, that are added to each fit: a larger value makes lobes wider");
        io.knob("regularisation", regularisation_, 0, 0.1f,
                "variance added to the lobe on each axis of the unit square");
        io.knob("normal_threshold", normalThreshold_, -1, 1,
                "smallest cosine between the shading normals of pixels that share samples");
        io.knob("depth_threshold", depthThreshold_, 0, 1000,
                "largest relative difference of their distances from the camera");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("GuidingScreen.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(
            kernel_,
            GuidingScreenParameters{frame.constants(), surface_->address(), previousSurface_->address(),
                                    motion_->address(), samples_->address(), history_->address(),
                                    addressOf(statistics_), addressOf(guide_), addressOf(direction_), addressOf(peak_),
                                    samples_.countPerPixel<GuidingSample>(), lobe_, product_, neighbours_,
                                    smoothingFloor_, prior_, regularisation_, normalThreshold_, depthThreshold_});
    }

private:
    In<Buffer> surface_, motion_, previousSurface_, samples_, history_;
    Out<Buffer> guide_, statistics_, direction_, peak_;
    uint32_t lobe_ = SCREEN_LOBE_GAUSSIAN;
    bool product_ = false;
    float smoothingFloor_ = 0.02f;
    uint32_t neighbours_ = 4;
    float prior_ = 1;
    float regularisation_ = 1e-3f;
    float normalThreshold_ = 0.5f;
    float depthThreshold_ = 0.1f;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GuidingScreen;
RESTIRPG_PASS(
    GuidingScreen,
    "Fits one lobe per pixel to where the frames before found indirect light, to guide the primary hit's bounce")
