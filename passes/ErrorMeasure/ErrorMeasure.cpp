// MAPE, relMSE, RMSE and signed bias of an image against a reference, measured on the device frame by frame.
#include "Shared.h"

#include "image/image.h"
#include "render/frame.h"

#include <array>

namespace restirpg {

static_assert(sizeof(MeasuredErrors) == 20);
static_assert(sizeof(ErrorMeasureParameters) == 7 * sizeof(Address));

class ErrorMeasure final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("image", image_, image(3), "the image to judge, linear and unclamped");
        io.output("map", map_, image(1), "each pixel's term of MAPE; 0 where a value is not finite");
        io.output("errors", errors_, fixedSize("Errors", [] { return sizeof(MeasuredErrors); }),
                  "MAPE, relMSE, RMSE, signed bias and the number of invalid pixels");
        io.knob("reference", reference_, "path of the reference EXR, of the image's size");
        io.structural();
    }

    // Not in check(): --set may name the file of a graph that was loaded without it.
    void build(Device& device) override
    {
        if (reference_.empty())
            fail("it needs a reference: set its knob 'reference' to the path of an EXR file");
        const Image reference = readExr(reference_);
        width_ = reference.width;
        height_ = reference.height;
        referenceBuffer_ = device.createBuffer(reference.data, "ErrorMeasure reference");
        lanes_ = device.createBuffer(LANES * sizeof(ErrorSums), "ErrorMeasure lanes");
        total_ = device.createBuffer(sizeof(ErrorSums), "ErrorMeasure total");
        for (size_t stage = 0; stage < stages_.size(); ++stage)
            stages_[stage] = Kernel(device, passFile("ErrorMeasure.comp"), {{"STAGE", std::to_string(stage)}});
    }

    void record(Frame& frame) override
    {
        if (frame.width() != width_ || frame.height() != height_)
            fail("{}: the reference is {}x{} but the image is {}x{}; render at the reference's size", reference_,
                 width_, height_, frame.width(), frame.height());
        const ErrorMeasureParameters parameters{frame.constants(), image_->address(), referenceBuffer_.address(),
                                                lanes_.address(),  total_.address(),  addressOf(map_),
                                                addressOf(errors_)};
        for (size_t stage = 0; stage < stages_.size(); ++stage)
            frame.dispatch(stages_[stage], parameters, stage % 2 == 0 ? LANES : 1);
    }

private:
    In<Buffer> image_;
    Out<Buffer> map_, errors_;
    std::string reference_;
    uint32_t width_ = 0, height_ = 0;
    Buffer referenceBuffer_, lanes_, total_;
    std::array<Kernel, 4> stages_;  ///< STAGE of ErrorMeasure.comp
};

RESTIRPG_PASS(ErrorMeasure, "Measures the error of an image against a reference EXR")

}  // namespace restirpg
