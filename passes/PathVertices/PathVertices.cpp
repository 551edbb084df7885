#include "Shared.h"
#include "render/frame.h"
#include "shaders/restir/path_reservoir_types.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

class PathVertices final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel, through its centre");
        io.ofThisFrame();
        io.input("paths", paths_, perPixel<PathReservoir>("PathReservoir"),
                 "paths, one per pixel, of PathTracerGuided or ReSTIRReuse");
        io.output("vertices", vertices_, severalPerPixel<PathVertex>("PathVertices", [] { return PATH_TOLD; }),
                  "the bounces that each path's reservoir tells, from the primary hit on, as the path stands in this "
                  "pixel");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("PathVertices.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(kernel_, PathVerticesParameters{frame.constants(), surface_->address(), paths_->address(),
                                                             vertices_->address()});
    }

private:
    In<Buffer> surface_, paths_;
    Out<Buffer> vertices_;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::PathVertices;
RESTIRPG_PASS(PathVertices, "Writes the bounces of each pixel's path, for inspection")
