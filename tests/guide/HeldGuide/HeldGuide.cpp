// A guide of GuidingFit as it came, as it was once, or with lobes that mean nothing. Whatever a guide knows, the mean
// must stay.
#include "HeldGuideShared.h"
#include "render/frame.h"
#include "shaders/guide/guiding_grid_types.h"

namespace restirpg {

class HeldGuide final : public Pass {
public:
    void describe(Interface& io) override
    {
        const auto layout = fixedSize("", [this] { return bytes(); });
        const PortType type = guide("GridGuide", layout, RESTIRPG_PASSES "/GuidingFit/guide.glsl");
        io.input("guide", guide_, type, "a guide of GuidingFit that remembers, one frame ago");
        io.optionalInput("history", history_, type, "the output guide, one frame ago; needed by `frozen`");
        io.output("guide", held_, type, "what is made of it");
        io.output("wrong", wrong_, guide("WrongGridGuide", layout, passFile("wrong_guide.glsl")),
                  "the live guide, with a density that is 10% too small");
        io.knob("cells", cells_, 1u << 10, 1u << 21, "slots, as GuidingFit's: a power of two");
        io.structural();
        io.choice("mode", mode_, {{"live", Mode::live}, {"frozen", Mode::frozen}, {"garbage", Mode::garbage}},
                  "the guide, what it was in frame `from`, or its cells with random narrow lobes");
        io.knob("from", from_, 0, 1000, "frame of the guide that is frozen");
    }

    void build(Device& device) override { kernel_ = Kernel(device, passFile("HeldGuide.comp")); }

    void record(Frame& frame) override
    {
        if (wrong_)
            frame.copy(*guide_.resource, *wrong_.resource);
        if (!held_)
            return;
        const bool frozen = history_ && mode_ == Mode::frozen && frame.index() > from_;
        frame.copy(frozen ? *history_.resource : *guide_.resource, *held_.resource);
        if (mode_ == Mode::garbage)
            frame.dispatch(kernel_, HeldGuideParameters{frame.constants(), held_->address()}, cells_);
    }

private:
    enum class Mode { live, frozen, garbage };

    uint64_t bytes() const
    {
        return GUIDING_HEADER_BYTES + uint64_t(GUIDING_KEY_BYTES + GUIDING_CELL_BYTES + GUIDING_MEMORY_BYTES) * cells_;
    }

    In<Buffer> guide_, history_;
    Out<Buffer> held_, wrong_;
    uint32_t cells_ = 4096;
    Mode mode_ = Mode::live;
    uint32_t from_ = 4;
    Kernel kernel_;
};

}  // namespace restirpg

using restirpg::HeldGuide;
RESTIRPG_PASS(HeldGuide, "A test's guide: live, frozen or garbage")
