// Passes that declare ports and knobs as real ones do, and touch no GPU: what the graph half is tested on.
#pragma once

#include "graph/graph.h"

namespace restirpg::test {

/// A pass that only describes itself.
class FakePass : public Pass {
public:
    void build(Device&) override {}
    void record(Frame&) override {}
};

class GBuffer final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.output("surface", surface_, {"Surface", 0, 48, {}}, "First hit");
        io.output("normal", normal_, image(3), "Shading normal");
        io.output("depth", depth_, image(1), "Distance to the camera");
        io.knob("jitter", jitter_, "Move the sample inside the pixel");
    }

private:
    Out<Buffer> surface_, normal_, depth_;
    bool jitter_ = false;
};

class Paths final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.input("surface", surface_, {"Surface", 0, 48, {}}, "First hit");
        io.optionalInput("guide", guide_, fixedSize("Guide", [] { return 1024; }), "Where to go");
        io.output("radiance", radiance_, image(3), "Radiance");
        io.output("vertices", vertices_, {"PathVertices", 0, 16, {}}, "Path vertices");
        io.knob("bounces", bounces_, 0, 64, "Longest path");
        io.structural();
        io.knob("roughness", roughness_, 0.0f, 0.9f, "Smallest");
        io.knob("offset", offset_, -5, 5, "A signed number");
        io.choice("cells", cells_, {{"world", Cells::world}, {"screen", Cells::screen}}, "Where cells lie");
        io.knob("note", note_, "Any text");
        io.knob("nee", nee_, "Sample lights");
    }

private:
    enum class Cells { world, screen };

    In<Buffer> surface_, guide_;
    Out<Buffer> radiance_, vertices_;
    uint32_t bounces_ = 8;
    float roughness_ = 0.1f;
    int32_t offset_ = 0;
    Cells cells_ = Cells::world;
    std::string note_;
    bool nee_ = true;
};

class Fit final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.input("vertices", vertices_, {"PathVertices", 0, 16, {}}, "Path vertices");
        io.output("guide", guide_, fixedSize("Guide", [] { return 1024; }), "Where to go");
        io.knob("bounces", bounces_, 0, 64, "How many to learn from");
    }

private:
    In<Buffer> vertices_;
    Out<Buffer> guide_;
    uint32_t bounces_ = 4;
};

class Accumulate final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("direct", direct_, image(3), "Radiance");
        io.optionalInput("indirect", indirect_, image(3), "Radiance");
        io.input("history", history_, {"Sums", 0, 32, {}}, "Sums of the frames before");
        io.output("sums", sums_, {"Sums", 0, 32, {}}, "Sums");
        io.output("mean", mean_, image(3), "Mean");
    }

private:
    In<Buffer> direct_, indirect_, history_;
    Out<Buffer> sums_, mean_;
};

/// One image through, another along: for chains, ties and cycles.
class Blur final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("image", image_, image(3), "Picture");
        io.optionalInput("other", other_, image(3), "Second picture");
        io.output("blurred", blurred_, image(3), "Picture");
    }

private:
    In<Buffer> image_, other_;
    Out<Buffer> blurred_;
};

/// Has inputs that go together.
class Reuse final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.optionalInput("motion", motion_, image(3), "Picture");
        io.optionalInput("history", history_, image(3), "Second picture");
        io.together({"motion", "history"});
        io.output("merged", merged_, image(3), "Picture");
    }

private:
    In<Buffer> motion_, history_;
    Out<Buffer> merged_;
};

/// Puts together what is no optional input.
class Apart final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.input("image", image_, image(3), "Picture");
        io.together({"image"});
    }

private:
    In<Buffer> image_;
};

/// Has a choice that none of its names is for.
class Nameless final : public FakePass {
public:
    void describe(Interface& io) override { io.choice("curve", curve_, {{"linear", 0}, {"filmic", 1}}, "Tone curve"); }

private:
    int32_t curve_ = 2;
};

/// Declares the same name twice.
class Twice final : public FakePass {
public:
    void describe(Interface& io) override
    {
        io.input("image", image_, image(3), "Picture");
        io.knob("image", knob_, "Clashes with the input");
    }

private:
    In<Buffer> image_;
    bool knob_ = false;
};

template <typename Type>
const PluginEntry* entry(const char* name)
{
    static const PluginEntry ENTRY{PLUGIN_ABI, name, "A fake",
                                   []() -> std::unique_ptr<Pass> { return std::make_unique<Type>(); }};
    return &ENTRY;
}

inline Plugins fakePlugins()
{
    return Plugins({entry<GBuffer>("GBuffer"), entry<Paths>("Paths"), entry<Fit>("Fit"),
                    entry<Accumulate>("Accumulate"), entry<Blur>("Blur"), entry<Twice>("Twice"), entry<Reuse>("Reuse"),
                    entry<Apart>("Apart"), entry<Nameless>("Nameless")});
}

}  // namespace restirpg::test
