#include "Shared.h"
#include "graph/grid_knobs.h"
#include "render/frame.h"
#include "shaders/restir/path_reservoir_types.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

class GuidingSplat final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.optionalInput("paths", paths_, perPixel<PathReservoir>("PathReservoir"),
                         "resampled paths, whose bounces have weight 1; wire this or `samples`");
        io.together({"surface", "paths"});
        // Whatever the bounce cap, the count of samples per pixel follows from the buffer's size.
        io.optionalInput("samples", samples_, anyPerPixel("GuidingSamples"),
                         "bounces of raw path trees, weighted by the light that came back; wire this or `paths`");
        io.input("guide", guide_, fixedSize("GridGuide", {}),
                 "the guide that drew the paths, one frame ago: prev(\"fit.guide\")");
        io.output("statistics", statistics_,
                  fixedSize("GuidingStatistics", [this] { return gridStatisticsBytes(capacity(), parallax_); }),
                  "sufficient statistics of this frame, per cell");
        cellsKnob(io, cells_);
        cellSizeKnobs(io, cellSize_, smallestCell_);
        io.knob("rows", rows_, 1, 1u << 16,
                "largest number of pixel rows that are added per frame; of an image with more rows every n-th row is "
                "added, shifted by one row from frame to frame");
        io.knob("learned_bounces", learnedBounces_, 1, PATH_TOLD,
                "largest number of bounces of each path that are added, from the primary hit on");
        io.choice("final_edges", finalEdges_,
                  {{"all", FINAL_EDGES_ALL}, {"scattered", FINAL_EDGES_SCATTERED}, {"none", FINAL_EDGES_NONE}},
                  "which path edges that end on a light are added: all, only those found by scattering, or none");
        io.knob("incident", incident_,
                "divide by the BSDF and the cosine, so that lobes fit the incident radiance alone");
        io.knob("parallax", parallax_,
                "turn samples to the middle of their cell and add up distances, so that GuidingFit can aim lobes (its "
                "`parallax`)");
        io.structural();
    }

    void check() const override
    {
        if (bool(paths_) == bool(samples_))
            fail("it learns from paths or from samples; wire one of the two");
        if (paths_ && parallax_)
            fail("parallax=true needs samples: paths do not say how far their bounces look");
        if (samples_ && (incident_ || finalEdges_ != FINAL_EDGES_ALL))
            fail("incident and final_edges are for paths: samples have their weights, and none is marked as the last");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile(paths_ ? "Paths.comp" : "Samples.comp")); }

    void record(Frame& frame) override
    {
        GuidingSplatParameters parameters{};
        parameters.frame = frame.constants();
        parameters.surface = addressOf(surface_);
        parameters.paths = addressOf(paths_);
        parameters.samples = addressOf(samples_);
        parameters.guide = guide_->address();
        parameters.statistics = statistics_->address();
        parameters.stride = paths_ ? 1 : samples_.countPerPixel<GuidingSample>();
        parameters.capacity = capacity();
        parameters.learnedBounces = learnedBounces_;
        parameters.finalEdges = finalEdges_;
        parameters.incident = incident_;
        parameters.parallax = parallax_;
        parameters.cellSize = cellSize_;
        parameters.smallestCell = smallestCell_;
        parameters.rowStep = (frame.height() + rows_ - 1) / rows_;
        frame.fill(*statistics_.resource);
        frame.dispatch(kernel_, parameters, frame.width(),
                       (frame.height() + parameters.rowStep - 1) / parameters.rowStep, parameters.stride);
    }

private:
    uint32_t capacity() const { return gridCapacity(cells_); }

    In<Buffer> surface_, paths_, samples_, guide_;
    Out<Buffer> statistics_;
    uint32_t cells_ = 1u << 16;
    uint32_t rows_ = 1u << 16;
    float cellSize_ = 0.12f;
    float smallestCell_ = 1e-3f;
    uint32_t learnedBounces_ = PATH_TOLD;
    uint32_t finalEdges_ = FINAL_EDGES_ALL;
    bool incident_ = false;
    bool parallax_ = false;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GuidingSplat;
RESTIRPG_PASS(GuidingSplat, "Adds each path vertex to the sufficient statistics of its cell")
