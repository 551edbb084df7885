#include "Shared.h"
#include "render/frame.h"

#include <algorithm>

namespace restirpg {

namespace {

/// In the order of VIEW_*.
const std::vector<std::string> VIEWS = {"cell", "level", "samples", "age", "kappa", "weight", "guided"};

}  // namespace

class GuidingView final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.ofThisFrame();
        io.input("guide", guide_, fixedSize("GridGuide", {}), "a guide of GuidingFit, of this frame or the one before");
        io.output("image", image_, image(3), "false colours of the cells that the pixels see; black: no guide there");
        io.choice("show", show_, VIEWS,
                  "what to show: cell: a random colour per cell; level: level of the grid; samples: number at the last "
                  "fit; age: frames since the last fit; kappa: the largest; weight: of the heaviest lobe; guided: "
                  "learned probability of the guide");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("GuidingView.comp")); }

    void record(Frame& frame) override
    {
        const auto show = uint32_t(std::find(VIEWS.begin(), VIEWS.end(), show_) - VIEWS.begin());
        frame.dispatchPixels(kernel_, GuidingViewParameters{frame.constants(), surface_->address(), guide_->address(),
                                                            image_->address(), show});
    }

private:
    In<Buffer> surface_, guide_;
    Out<Buffer> image_;
    std::string show_ = "cell";
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GuidingView;
RESTIRPG_PASS(GuidingView, "Shows the cells of the guiding grid in false colours")
