// Measures the hybrid shift and the MIS weights of ReSTIRReuse, with that pass's own GLSL.
#include "Shared.h"
#include "render/frame.h"

#include <algorithm>
#include <array>

namespace restirpg {

class ShiftProbe final : public Pass {
public:
    void describe(Interface& io) override
    {
        const PortType reservoir = perPixel<PathReservoir>("PathReservoir");
        io.input("surface", surface_, perPixel<PrimaryHit>("Surface"), "primary hit of each pixel");
        io.input("previous_surface", previousSurface_, perPixel<PrimaryHit>("Surface"), "the same, one frame ago");
        io.input("reservoirs", reservoirs_, reservoir, "paths of this frame");
        io.input("history", history_, reservoir, "paths of the frame before");
        const std::string trip = "kind, relative difference of f, |J J' - 1| and end of a shift and its way back: ";
        io.output("stay", trips_[WAY_STAY], image(4), trip + "in the pixel's own domain");
        io.output("neighbour", trips_[WAY_NEIGHBOUR], image(4), trip + "to a pixel nearby");
        io.output("previous", trips_[WAY_PREVIOUS], image(4), trip + "to the frame before");
        const std::string jacobian =
            "kind, measured over claimed Jacobian, the claimed one, and whether it could be measured: ";
        io.output("neighbour_jacobian", jacobians_[WAY_NEIGHBOUR], image(4), jacobian + "to a pixel nearby");
        io.output("previous_jacobian", jacobians_[WAY_PREVIOUS], image(4), jacobian + "to the frame before");
        const std::string sums =
            "how far from 1 the weights of own and of others' paths add up to, and how many were tried: ";
        io.output("spatial_sums", sums_[WAY_NEIGHBOUR], image(4), sums + "spatial reuse");
        io.output("temporal_sums", sums_[WAY_PREVIOUS], image(4), sums + "temporal reuse");
    }

    void build(Device& device) override
    {
        roundTrip_ = Kernel(device, passFile("RoundTrip.comp"), {}, {}, compileIf(isWired(trips_)));
        jacobian_ = Kernel(device, passFile("Jacobian.comp"), {}, {}, compileIf(isWired(jacobians_)));
        partition_ = Kernel(device, passFile("Partition.comp"), {}, {}, compileIf(isWired(sums_)));
    }

    void record(Frame& frame) override
    {
        for (const uint32_t way : {WAY_STAY, WAY_NEIGHBOUR, WAY_PREVIOUS}) {
            run(frame, roundTrip_, trips_[way], way);
            run(frame, jacobian_, jacobians_[way], way);
            run(frame, partition_, sums_[way], way);
        }
    }

private:
    static bool isWired(const std::array<Out<Buffer>, 3>& outputs)
    {
        return std::any_of(outputs.begin(), outputs.end(), [](const auto& output) { return bool(output); });
    }

    void run(Frame& frame, const Kernel& kernel, const Out<Buffer>& result, uint32_t way)
    {
        if (!result)
            return;
        if (way == WAY_PREVIOUS && frame.reset())  // a zeroed surface is no surface
            frame.fill(*result.resource);
        else
            frame.dispatchPixels(kernel, ShiftProbeParameters{frame.constants(), surface_->address(),
                                                              previousSurface_->address(), reservoirs_->address(),
                                                              history_->address(), result->address(), way});
    }

    In<Buffer> surface_, previousSurface_, reservoirs_, history_;
    std::array<Out<Buffer>, 3> trips_, jacobians_, sums_;  ///< by WAY_*
    Kernel roundTrip_, jacobian_, partition_;
};

RESTIRPG_PASS(ShiftProbe, "Measures shifts, their Jacobians and the weights of ReSTIRReuse")

}  // namespace restirpg
