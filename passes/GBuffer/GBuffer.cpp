#include "Shared.h"
#include "render/frame.h"

namespace restirpg {

class GBuffer final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.output("surface", surface_, perPixel<PrimaryHit>("Surface"),
                  "primary hit: instance, triangle, barycentrics; packed normal and distance from the camera");
        io.output("emission", emission_, image(3),
                  "radiance that the primary hit, or the environment behind a miss, emits to the camera, W/sr/m^2");
        io.output("normal", normal_, image(3), "shading normal in world space, on the camera's side; 0 at a miss");
        io.output("geometric_normal", geometricNormal_, image(3),
                  "geometric normal in world space, on the camera's side; 0 at a miss");
        io.output("albedo", albedo_, image(3), "base colour, linear; 0 at a miss");
        io.output("depth", depth_, image(1), "distance along the camera's axis, m; 0 at a miss");
        io.output("motion", motion_, motionVectors(),
                  "where the point was in the frame before, minus where it is, in pixels (x right, y down); NaN where "
                  "it was behind the camera");
        io.output("material", material_, image(1), "index of the material; -1 at a miss");
        io.knob("jitter", jitter_,
                "sample the pixel uniformly (box filter) instead of at its centre; reuse over pixels or frames needs "
                "the centre");
        io.structural();
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("GBuffer.comp")); }

    void record(Frame& frame) override
    {
        const GBufferParameters parameters{frame.constants(),           addressOf(surface_),
                                           addressOf(emission_),        addressOf(normal_),
                                           addressOf(geometricNormal_), addressOf(albedo_),
                                           addressOf(depth_),           addressOf(motion_),
                                           addressOf(material_),        jitter_};
        frame.dispatchPixels(kernel_, parameters);
    }

private:
    Out<Buffer> surface_, emission_, normal_, geometricNormal_, albedo_, depth_, motion_, material_;
    bool jitter_ = false;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::GBuffer;
RESTIRPG_PASS(GBuffer, "Traces the primary rays: what each pixel sees, and how it moved")
