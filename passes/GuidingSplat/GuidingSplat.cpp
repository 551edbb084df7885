#include "Shared.h"
#include "graph/grid_knobs.h"
#include "render/frame.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

class GuidingSplat final : public Pass {
public:
    void describe(Interface& io) override
    {
        // Whatever the bounce cap, readers take the vertices' count per pixel from the buffer's size.
        io.optionalInput("vertices", vertices_, anyPerPixel("PathVertices"),
                         "bounces of resampled paths, each of weight 1; wire this or `samples`");
        io.optionalInput("samples", samples_, anyPerPixel("GuidingSamples"),
                         "bounces of raw path trees, weighted by the light that came back; wire this or `vertices`");
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
        if (bool(vertices_) == bool(samples_))
            fail("it learns from vertices or from samples; wire one of the two");
        if (vertices_ && parallax_)
            fail("parallax=true needs samples: vertices do not say how far they look");
        if (samples_ && (incident_ || finalEdges_ != FINAL_EDGES_ALL))
            fail("incident and final_edges are for vertices: samples have their weights, and none is marked as the "
                 "last");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("Splat.comp")); }

    void record(Frame& frame) override
    {
        GuidingSplatParameters parameters{};
        parameters.frame = frame.constants();
        parameters.vertices = addressOf(vertices_);
        parameters.samples = addressOf(samples_);
        parameters.guide = guide_->address();
        parameters.statistics = statistics_->address();
        parameters.stride = vertices_ ? vertices_.countPerPixel<PathVertex>() : samples_.countPerPixel<GuidingSample>();
        parameters.capacity = capacity();
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

    In<Buffer> vertices_, samples_, guide_;
    Out<Buffer> statistics_;
    uint32_t cells_ = 1u << 16;
    uint32_t rows_ = 1u << 16;
    float cellSize_ = 0.12f;
    float smallestCell_ = 1e-3f;
    uint32_t finalEdges_ = FINAL_EDGES_ALL;
    bool incident_ = false;
    bool parallax_ = false;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GuidingSplat;
RESTIRPG_PASS(GuidingSplat, "Adds each path vertex to the sufficient statistics of its cell")
