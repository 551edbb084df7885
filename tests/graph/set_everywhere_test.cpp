// One value for all knobs of a name, on a renderer: all are turned or none.
#include "../gpu/gpu_test.h"
#include "../scene/gltf_builder.h"
#include "describing.h"

#include "render/renderer.h"

#include <gtest/gtest.h>

namespace restirpg::test {
namespace {

/// A structural knob up to MOST; it cannot be built with 13.
template <uint32_t MOST>
class Counting final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.output("image", image_, image(3), "Picture");
        io.knob("count", count_, 1, MOST, "How many");
        io.structural();
    }
    void build(Device&) override
    {
        if (MOST < 1000 && count_ == 13)
            fail("13 is not built");
    }
    void record(Frame&) override {}

private:
    Out<Buffer> image_;
    uint32_t count_ = 1;
};

std::unique_ptr<Graph> graphOf(uint32_t count)
{
    Writer writer;
    writer.add("wide", "Wide", {}, {{"count", count}}).add("narrow", "Narrow", {}, {{"count", count}});
    writer.output("one", "wide.image").output("two", "narrow.image");
    return std::make_unique<Graph>(writer.graph,
                                   Plugins({entry<Counting<1000>>("Wide"), entry<Counting<20>>("Narrow")}));
}

class SetEverywhere : public testing::Test {
protected:
    /// What the knobs are, and what the graph file's are taken for after it has been edited.
    void expectUnchanged(uint32_t count)
    {
        for (const char* path : {"wide.count", "narrow.count"})
            EXPECT_EQ(renderer_.knob(path), count);
        renderer_.reload(graphOf(7));
        for (const char* path : {"wide.count", "narrow.count"})
            EXPECT_EQ(renderer_.knob(path), 7u) << "the refused value, or the one before it, is kept";
    }

    Renderer renderer_{
        std::make_shared<const Scene>(load(squareScene())), graphOf(5),
        RendererOptions{.width = 8, .height = 8, .device = DeviceOptions{.device = testDevice(), .validation = true}}};
};

TEST_F(SetEverywhere, AValueThatOnePassRefusesChangesNothing)
{
    renderer_.render(2);
    const auto refused = errorOf([&] { renderer_.setKnobEverywhere("count", 100); });
    EXPECT_EQ(refused, "pass 'narrow' (Narrow): knob 'count' must be a whole number from 1 to 20, not 100");
    EXPECT_EQ(renderer_.frame(), 2u) << "it was no cut";
    expectUnchanged(5);
}

TEST_F(SetEverywhere, AValueThatOnePassIsNotBuiltWithChangesNoKnob)
{
    EXPECT_NE(errorOf([&] { renderer_.setKnobEverywhere("count", 13); }).find("13 is not built"), std::string::npos);
    expectUnchanged(5);
}

TEST_F(SetEverywhere, AValueThatAllTakeStaysWhenTheGraphIsReadAnew)
{
    EXPECT_EQ(renderer_.setKnobEverywhere("count", 9), 2u);
    renderer_.reload(graphOf(7));
    EXPECT_EQ(renderer_.knob("wide.count"), 9u);
    EXPECT_EQ(renderer_.knob("narrow.count"), 9u);
}

}  // namespace
}  // namespace restirpg::test
