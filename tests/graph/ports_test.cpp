// Which output an input takes: by what it means, how large it is and of which frame it is. And what plugins' own checks
// refuse.
#include "describing.h"

#include <gtest/gtest.h>

namespace restirpg::test {
namespace {

/// Two guides of one size and different meanings.
class Guides final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.output("grid", grid_, guide("GridGuide", fixedSize("", [] { return 1024; }), "grid.glsl"), "A cell each");
        io.output("screen", screen_, guide("ScreenGuide", fixedSize("", [] { return 1024; }), "screen.glsl"),
                  "A pixel each");
    }

private:
    Out<Buffer> grid_, screen_;
};

class Reader final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("any", any_, anyGuide(), "Read by its module");
        io.optionalInput("grid", grid_, fixedSize("GridGuide", {}), "Read as cells");
        io.optionalInput("history", history_, image(3), "Made one frame ago");
        io.ofFrameBefore();
        io.optionalInput("now", now_, image(3), "Made in this frame");
        io.ofThisFrame();
        io.output("image", image_, image(3), "Picture");
    }

    void check() const override
    {
        if (any_ && grid_)
            fail("it reads one guide; leave {} unwired", any_.module == "grid.glsl" ? "grid" : "any");
    }

private:
    In<Buffer> any_, grid_, history_, now_;
    Out<Buffer> image_;
};

/// Makes as many bytes, or wants as many, as its knob says.
class Sized final : public FakePass {
public:
    void describe(Interface& io) override
    {
        const PortType type = severalPerPixel<float>("Items", [this] { return items_; });
        io.optionalInput("items", in_, type, "Items");
        io.optionalInput("any", any_, PortType{"Items", 0, 0, {}}, "As many as there are");
        io.output("items", out_, type, "Items");
        io.knob("count", items_, 1, 8, "Items a pixel");
        io.structural();
    }

private:
    In<Buffer> in_, any_;
    Out<Buffer> out_;
    uint32_t items_ = 2;
};

struct Throwing final : FakePass {
    enum class Where { constructor, description, size, check, number } where;
    explicit Throwing(Where place) : where(place)
    {
        if (where == Where::constructor)
            throw std::runtime_error("bad day");
    }
    void describe(Interface& io) override
    {
        io.output("image", image_, image(3), "Picture");
        if (where == Where::size)
            io.output("sized", sized_, fixedSize("Sized", []() -> uint64_t { throw std::runtime_error("bad day"); }),
                      "Items");
        if (where == Where::description)
            throw std::runtime_error("bad day");
        if (where == Where::number)
            throw 42;
    }
    void check() const override
    {
        if (where == Where::check)
            throw std::runtime_error("bad day");
    }

private:
    Out<Buffer> image_, sized_;
};

template <Throwing::Where where>
const PluginEntry* throwing(const char* name)
{
    static const PluginEntry ENTRY{PLUGIN_ABI, name, "A fake",
                                   []() -> std::unique_ptr<Pass> { return std::make_unique<Throwing>(where); }};
    return &ENTRY;
}

const PluginEntry* none()
{
    static const PluginEntry ENTRY{PLUGIN_ABI, "None", "A fake", []() -> std::unique_ptr<Pass> { return nullptr; }};
    return &ENTRY;
}

Plugins plugins()
{
    using Where = Throwing::Where;
    return Plugins({entry<Guides>("Guides"), entry<Reader>("Reader"), entry<Sized>("Sized"),
                    throwing<Where::constructor>("Made"), throwing<Where::description>("Described"),
                    throwing<Where::check>("Checked"), throwing<Where::size>("Measured"),
                    throwing<Where::number>("Number"), none()});
}

std::string refusalOf(const Writer& writer)
{
    try {
        Graph(writer.graph, plugins());
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

/// "guides" and, on line 2, "reader" wired as told.
std::string reading(std::initializer_list<std::pair<const char*, const char*>> inputs)
{
    Writer writer;
    writer.add("guides", "Guides").add("reader", "Reader", inputs).output("image", "reader.image");
    return refusalOf(writer);
}

TEST(GraphPorts, AFamilysInputTakesAllOfItAndOneTypesInputThatTypeAlone)
{
    EXPECT_EQ(reading({{"any", "guides.grid"}}), "");
    EXPECT_EQ(reading({{"any", "guides.screen"}}), "");
    EXPECT_EQ(reading({{"grid", "guides.grid"}}), "");
    EXPECT_EQ(
        reading({{"grid", "~guides.screen"}}),
        "g.py:2: input 'grid' of pass 'reader' (Reader) takes GridGuide, but prev(\"guides.screen\") is ScreenGuide\n"
        "    outputs of type GridGuide: guides.grid");
    EXPECT_EQ(reading({{"any", "reader.image"}}),
              "g.py:2: input 'any' of pass 'reader' (Reader) takes Guide, but reader.image is Image3\n"
              "    outputs of type Guide: guides.grid, guides.screen");
}

TEST(GraphPorts, AnInputThatIsOfOneFrameTakesNoOther)
{
    EXPECT_EQ(reading({{"history", "~reader.image"}}), "");
    Writer writer;
    writer.add("first", "Reader")
        .add("reader", "Reader", {{"history", "first.image"}, {"now", "~first.image"}})
        .output("image", "reader.image");
    EXPECT_EQ(refusalOf(writer), "g.py:2: input 'history' of pass 'reader' (Reader) takes what was made one frame ago, "
                                 "but first.image is of this frame\n"
                                 "    wire it to prev(\"first.image\")\n"
                                 "g.py:2: input 'now' of pass 'reader' (Reader) takes what was made in this frame, but "
                                 "prev(\"first.image\") is of the frame "
                                 "before\n"
                                 "    wire it to first.image");
}

TEST(GraphPorts, SizesThatKnobsGiveMustAgree)
{
    const auto sized = [](uint32_t made, uint32_t wanted, const char* input) {
        Writer writer;
        writer.add("a", "Sized", {}, {{"count", made}})
            .add("b", "Sized", {{input, "a.items"}}, {{"count", wanted}})
            .output("o", "b.items");
        return writer;
    };
    EXPECT_EQ(refusalOf(sized(3, 3, "items")), "");
    EXPECT_EQ(refusalOf(sized(3, 2, "any")), "");
    EXPECT_EQ(
        refusalOf(sized(3, 2, "items")),
        "g.py:2: input 'items' of pass 'b' (Sized) reads 8 B/pixel, but a.items of pass 'a' (Sized) has 12 B/pixel\n"
        "    give both the same knobs: 'count' (2 and 3)");
    // A graph that was right, on its way from one value to another.
    Graph graph(sized(3, 3, "items").graph, plugins());
    graph.setKnob("a.count", 5);
    EXPECT_THROW(graph.check(), Error);
    graph.setKnob("b.count", 5);
    EXPECT_NO_THROW(graph.check());
    Writer culled = sized(3, 2, "items");
    culled.graph["outputs"] = json::array();
    culled.output("o", "a.items");
    EXPECT_EQ(refusalOf(culled), "") << "a pass that does not run reads nothing";
}

TEST(GraphPorts, APassesOwnCheckIsLocated)
{
    EXPECT_EQ(reading({{"any", "guides.grid"}, {"grid", "guides.grid"}}),
              "g.py:2: pass 'reader' (Reader): it reads one guide; leave grid unwired");
}

TEST(GraphPorts, ACopyOfAPassHasItsWiringAndKnobs)
{
    Writer writer;
    writer.add("a", "Sized", {}, {{"count", 3}})
        .add("b", "Sized", {{"items", "a.items"}}, {{"count", 3}})
        .output("o", "b.items");
    Graph graph(writer.graph, plugins());
    auto& original = *graph.find("b");
    const GraphPass copy = graph.copyOf(original);
    EXPECT_NE(copy.pass.get(), original.pass.get());
    EXPECT_EQ(copy.interface.knobs()[0].get(), 3);
    EXPECT_TRUE(*copy.interface.inputs()[0].target && *copy.interface.outputs()[0].target);
    EXPECT_FALSE(*copy.interface.inputs()[1].target);
    EXPECT_NE(copy.interface.inputs()[0].target, original.interface.inputs()[0].target);
    graph.setKnob("b.count", 4);
    EXPECT_EQ(copy.interface.knobs()[0].get(), 3);
}

TEST(GraphPlugins, ACodeThatThrowsIsNamed)
{
    const auto alone = [](const char* type) {
        Writer writer;
        writer.add("it", type).output("image", "it.image");
        return refusalOf(writer);
    };
    EXPECT_EQ(alone("Made"), "g.py:1: pass 'it' (Made) cannot be created: bad day");
    EXPECT_EQ(alone("Described"), "g.py:1: pass 'it' (Described) describes itself wrongly: bad day");
    EXPECT_EQ(alone("Number"),
              "g.py:1: pass 'it' (Number) describes itself wrongly: it threw something that is not a std::exception");
    EXPECT_EQ(alone("Checked"), "g.py:1: pass 'it' (Checked): bad day");
    EXPECT_EQ(alone("Measured"), "g.py:1: pass 'it' (Measured): bad day");
    EXPECT_EQ(alone("None"), "g.py:1: pass 'it' (None) cannot be created: its plugin gave none");
}

}  // namespace
}  // namespace restirpg::test
