// A pass whose code throws on the device: the message names it, and the renderer's state stays as it was.
#include "../gpu/gpu_test.h"
#include "describing.h"

#include "render/executor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <stdexcept>

#include <sys/resource.h>
#include <unistd.h>

namespace restirpg::test {
namespace {

/// Throws where its knob says.
class Throwing final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("history", history_, image(3), "Picture of the frame before");
        io.output("image", image_, image(3), "Picture");
        io.choice("built", built_, CHOICES, "What build throws");
        io.structural();
        io.choice("recorded", recorded_, CHOICES, "What record throws");
    }
    void build(Device&) override { throwAs(built_); }
    void record(Frame&) override
    {
        throwAs(recorded_);
        read = history_.resource;
        written = image_.resource;
    }

    static inline const Buffer *read = nullptr, *written = nullptr;  ///< of the last frame

private:
    enum class Thrown { nothing, error, number };
    static inline const std::vector<std::pair<std::string, Thrown>> CHOICES = {
        {"fine", Thrown::nothing}, {"error", Thrown::error}, {"number", Thrown::number}};

    static void throwAs(Thrown kind)
    {
        if (kind == Thrown::error)
            throw std::runtime_error("bad\nday\x1b");
        if (kind == Thrown::number)
            throw 42;
    }

    In<Buffer> history_;
    Out<Buffer> image_;
    Thrown built_ = Thrown::nothing, recorded_ = Thrown::nothing;
};

/// Its kernel is not there.
class Kernelless final : public Pass {
public:
    void describe(Interface& io) override { io.output("image", image_, image(3), "Picture"); }
    void build(Device& device) override { kernel_ = Kernel(device, "/none/nowhere.comp"); }
    void record(Frame&) override {}

private:
    Out<Buffer> image_;
    Kernel kernel_;
};

/// Has as many values per pixel as its knob says.
class Several final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.output("values", values_, severalPerPixel<float>("Values", [this] { return count_; }), "Values");
        io.knob("count", count_, 1, 1000, "How many a pixel");
        io.structural();
    }
    void build(Device&) override {}
    void record(Frame&) override {}

private:
    Out<Buffer> values_;
    uint32_t count_ = 16;
};

/// Its output follows the size of its input, and cannot be had where that is large.
class Following final : public Pass {
public:
    void describe(Interface& io) override
    {
        io.input("values", values_, anyPerPixel("Values"), "Values");
        io.output("limited", limited_, severalPerPixel<float>("Limited", [this] { return atMost(100); }), "As many");
    }
    void build(Device&) override {}
    void record(Frame&) override {}

private:
    uint64_t atMost(uint64_t most) const
    {
        const uint64_t count = values_.pixelBytes() / sizeof(float);
        if (count > most)
            fail("{} values do not fit the memory", count);
        return count;
    }

    In<Buffer> values_;
    Out<Buffer> limited_;
};

/// So many bytes are left of it while this lives.
class AddressSpace {
public:
    explicit AddressSpace(rlim_t bytes)
    {
        getrlimit(RLIMIT_AS, &before_);
        rlim_t pages = 0;
        std::ifstream("/proc/self/statm") >> pages;
        const rlimit limited{pages * rlim_t(getpagesize()) + bytes, before_.rlim_max};
        setrlimit(RLIMIT_AS, &limited);
    }
    ~AddressSpace() { setrlimit(RLIMIT_AS, &before_); }

private:
    rlimit before_{};
};

std::string messageOf(const std::function<void()>& action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

std::unique_ptr<Graph> graphOf(const json& knobs)
{
    Writer writer;
    writer.add("it", "Throwing", {{"history", "~it.image"}}, knobs).output("image", "it.image");
    return std::make_unique<Graph>(writer.graph, Plugins({entry<Throwing>("Throwing")}));
}

TEST(ThrowingPass, IsNamedWhenItBuilds)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    EXPECT_EQ(messageOf([&] {
                  Executor(device, graphOf({{"built", "error"}}), 8, 8, {});
              }),
              "g.py:1: pass 'it' (Throwing): bad\\nday\\x1b");
    EXPECT_EQ(messageOf([&] {
                  Executor(device, graphOf({{"built", "number"}}), 8, 8, {});
              }),
              "g.py:1: pass 'it' (Throwing): it threw something that is not a std::exception");
    EXPECT_EQ(device.allocatedBytes(), 0u);
}

TEST(ThrowingPass, LeavesNoKernelForTheNextOneToWaitFor)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    Writer writer;
    writer.add("before", "Kernelless").add("it", "Throwing", {{"history", "~it.image"}}, {{"built", "error"}});
    writer.output("one", "before.image").output("image", "it.image");
    const Plugins plugins({entry<Kernelless>("Kernelless"), entry<Throwing>("Throwing")});
    EXPECT_EQ(messageOf([&] { Executor(device, std::make_unique<Graph>(writer.graph, plugins), 8, 8, {}); }),
              "g.py:2: pass 'it' (Throwing): bad\\nday\\x1b");
    EXPECT_EQ(messageOf([&] { Executor(device, graphOf(json::object()), 8, 8, {}); }), "");
}

TEST(ThrowingPass, IsNamedWhenItRecordsOrIsBuiltAnewAndRunsAfterwards)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    const BindingSet noScene(device);
    Executor executor(device, graphOf(json::object()), 8, 8, {});
    auto& pass = executor.graph().passes()[0];
    const auto run = [&] { executor.run({}, noScene); };
    EXPECT_EQ(messageOf(run), "");
    const Buffer* first = Throwing::written;
    executor.setKnob(pass, "recorded", "error");
    EXPECT_EQ(messageOf(run), "g.py:1: pass 'it' (Throwing): bad\\nday\\x1b");
    EXPECT_EQ(executor.latest(0, 0), first);
    executor.setKnob(pass, "recorded", "number");
    EXPECT_EQ(messageOf(run), "g.py:1: pass 'it' (Throwing): it threw something that is not a std::exception");
    executor.setKnob(pass, "recorded", "fine");
    EXPECT_EQ(messageOf(run), "");
    EXPECT_EQ(Throwing::read, first) << "history is that of the last frame that was";
    EXPECT_EQ(messageOf([&] { executor.setKnob(pass, "built", "error"); }),
              "g.py:1: pass 'it' (Throwing): bad\\nday\\x1b");
    EXPECT_EQ(pass.interface.knobs()[0].get(), "fine");
    EXPECT_EQ(messageOf(run), "");
    EXPECT_EQ(executor.frame(), 3u);
}

TEST(ThrowingPass, AKnobThatTheOutputsOfAnotherPassCannotFollowChangesNothing)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    const BindingSet noScene(device);
    Writer writer;
    writer.add("several", "Several").add("following", "Following", {{"values", "several.values"}});
    writer.output("limited", "following.limited");
    Executor executor(
        device,
        std::make_unique<Graph>(writer.graph, Plugins({entry<Several>("Several"), entry<Following>("Following")})), 8,
        8, {});
    auto& pass = executor.graph().passes()[0];
    executor.run({}, noScene);
    const auto memory = executor.memory();
    const auto bytes = device.allocatedBytes();
    EXPECT_EQ(messageOf([&] { executor.setKnob(pass, "count", 101); }), "101 values do not fit the memory");
    EXPECT_EQ(pass.interface.knobs()[0].get(), 16u);
    EXPECT_EQ(executor.memory(), memory);
    EXPECT_EQ(device.allocatedBytes(), bytes);
    EXPECT_EQ(executor.frame(), 1u);
    executor.run({}, noScene);
    executor.setKnob(pass, "count", 100);
    EXPECT_EQ(executor.frame(), 0u);
    for (const auto& [port, size] : executor.memory())
        EXPECT_EQ(size, 8u * 8u * 400u) << port;
    executor.run({}, noScene);
}

TEST(Executor, BuffersThatTheMemoryCannotHoldAreRefusedBeforeTheyAreMade)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    if (!device.isCpu())
        GTEST_SKIP() << "the device has memory of its own, whose driver refuses what it cannot give";
    Writer writer;
    writer.add("a", "Several", {}, {{"count", 20}}).add("b", "Several", {}, {{"count", 20}});
    writer.output("a", "a.values").output("b", "b.values");  // 80 MiB each
    const auto said = messageOf([&] {
        const AddressSpace enoughToTakeThem(300u << 20);
        Executor(device, std::make_unique<Graph>(writer.graph, Plugins({entry<Several>("Several")})), 1024, 1024, {});
    });
    EXPECT_TRUE(said.starts_with("graph 'Test': a frame of 1024x1024 pixels needs 160.0 MiB of memory, of which "))
        << said;
    EXPECT_TRUE(said.ends_with("; give a smaller --size or a --window")) << said;
    EXPECT_EQ(device.allocatedBytes(), 0u);
}

TEST(Executor, AnOutputOfMoreItemsThanKernelsCountIsRefusedBeforeItIsMade)
{
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    const auto graphWith = [](uint32_t count) {
        Writer writer;
        writer.add("it", "Several", {}, {{"count", count}}).output("values", "it.values");
        return std::make_unique<Graph>(writer.graph, Plugins({entry<Several>("Several")}));
    };
    const std::string refusal = "g.py:1: pass 'it' (Several): the output 'values' has 4297329000 items at 2073x2073 "
                                "pixels, of which kernels can count 4294967295; set a knob that it follows lower, or "
                                "render a window";
    EXPECT_EQ(messageOf([&] { Executor(device, graphWith(1000), 2073, 2073, {}); }), refusal);
    Executor executor(device, graphWith(1), 2073, 2073, {});
    EXPECT_EQ(messageOf([&] { executor.setKnob(executor.graph().passes()[0], "count", 1000); }), refusal);
    EXPECT_EQ(executor.graph().passes()[0].interface.knobs()[0].get(), 1u);
}

}  // namespace
}  // namespace restirpg::test
