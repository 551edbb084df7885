// Vertices whose distribution is known: one per pixel, spread evenly over some places that lie in cells of their own.
#include "KnownVerticesShared.h"
#include "render/frame.h"
#include "shaders/restir/path_vertex_types.h"

namespace restirpg {

class KnownVertices final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.output("vertices", vertices_, perPixel<PathVertex>("PathVertices"),
                  "one vertex a pixel, its direction drawn from the mixture of KnownVertices.comp");
        io.knob("places", places_, 1, 4096, "points at which the vertices lie, in a square of 64 x 64");
        io.knob("identical", identical_, "all directions are the axis of the first lobe");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("KnownVertices.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(kernel_,
                             KnownVerticesParameters{frame.constants(), vertices_->address(), places_, identical_});
    }

private:
    Out<Buffer> vertices_;
    uint32_t places_ = 1;
    bool identical_ = false;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::KnownVertices;
RESTIRPG_PASS(KnownVertices, "A test's vertices: directions of a known mixture")
