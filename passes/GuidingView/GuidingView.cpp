#include "Shared.h"
#include "render/frame.h"

namespace restirpg {

class GuidingView final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.input("guide", guide_, fixedSize("GridGuide", {}), "a guide of GuidingFit, of this frame or the one before");
        io.output("image", image_, image(3), "false colours of the cells that the pixels see; black: no guide there");
        io.choice("show", show_,
                  {{"cell", VIEW_CELL},
                   {"level", VIEW_LEVEL},
                   {"samples", VIEW_SAMPLES},
                   {"age", VIEW_AGE},
                   {"kappa", VIEW_KAPPA},
                   {"weight", VIEW_WEIGHT},
                   {"guided", VIEW_GUIDED}},
                  "what to show: cell: a random colour per cell; level: level of the grid; samples: number at the last "
                  "fit; age: frames since the last fit; kappa: the largest; weight: of the heaviest lobe; guided: "
                  "learned probability of the guide");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("GuidingView.comp")); }

    void record(Frame& frame) override
    {
        frame.dispatchPixels(kernel_, GuidingViewParameters{frame.constants(), surface_->address(), guide_->address(),
                                                            image_->address(), show_});
    }

private:
    In<Buffer> surface_, guide_;
    Out<Buffer> image_;
    uint32_t show_ = VIEW_CELL;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GuidingView;
RESTIRPG_PASS(GuidingView, "Shows the cells of the guiding grid in false colours")
