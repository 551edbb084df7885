// Order, culling, resources, knobs and the round trip of graphs that are right.
#include "describing.h"

#include "graph/describe.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace restirpg::test {
namespace {

std::vector<std::string> orderOf(const Graph& graph)
{
    std::vector<std::string> names;
    for (const uint32_t pass : graph.order())
        names.push_back(graph.passes()[pass].name);
    return names;
}

/// "pass.output", with " x2" where the frame before is kept.
std::vector<std::string> resourcesOf(const Graph& graph)
{
    std::vector<std::string> texts;
    for (const auto& resource : graph.resources()) {
        const auto& pass = graph.passes()[resource.pass];
        texts.push_back(pathOf(pass, pass.interface.outputs()[resource.output].name) + (resource.delayed ? " x2" : ""));
    }
    return texts;
}

std::string refusal(const std::function<void()>& action)
{
    try {
        action();
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

using Names = std::vector<std::string>;

TEST(GraphOrder, TiesAreInFileOrder)
{
    Writer writer;
    writer.add("d", "Blur")
        .add("c", "Blur")
        .add("b", "Blur")
        .add("a", "Blur", {{"image", "c.blurred"}, {"other", "b.blurred"}})
        .output("o1", "d.blurred")
        .output("o2", "a.blurred");
    EXPECT_EQ(orderOf(Graph(writer.graph, fakePlugins())), (Names{"d", "c", "b", "a"}));
}

TEST(GraphOrder, EdgesOverruleFileOrder)
{
    Writer writer;
    writer.add("last", "Blur", {{"image", "first.blurred"}})
        .add("other", "Blur")
        .add("first", "Blur")
        .output("o1", "last.blurred")
        .output("o2", "other.blurred");
    EXPECT_EQ(orderOf(Graph(writer.graph, fakePlugins())), (Names{"other", "first", "last"}));
}

TEST(GraphOrder, DelayedEdgesDoNotOrder)
{
    Writer writer;
    writer.add("a", "Blur", {{"image", "~b.blurred"}})
        .add("b", "Blur", {{"image", "a.blurred"}})
        .output("o", "b.blurred");
    EXPECT_EQ(orderOf(Graph(writer.graph, fakePlugins())), (Names{"a", "b"}));
}

TEST(GraphOrder, EveryEdgePointsForwardInRandomGraphs)
{
    std::mt19937 random(7);
    for (int trial = 0; trial < 200; ++trial) {
        // Passes 0..n-1 in a random file order; undelayed edges go from smaller to larger numbers: no cycle.
        const uint32_t count = 2 + random() % 12;
        std::vector<uint32_t> fileOrder(count);
        for (uint32_t i = 0; i < count; ++i)
            fileOrder[i] = i;
        std::shuffle(fileOrder.begin(), fileOrder.end(), random);
        Writer writer;
        for (const uint32_t pass : fileOrder) {
            const std::string undelayed = pass ? fmt::format("p{}.blurred", random() % pass) : "~p0.blurred";
            const std::string delayed = fmt::format("~p{}.blurred", random() % count);
            writer.add(fmt::format("p{}", pass), "Blur", {{"image", undelayed.c_str()}, {"other", delayed.c_str()}});
        }
        for (uint32_t i = 0; i < count; ++i)
            writer.output(fmt::format("o{}", i), fmt::format("p{}.blurred", i));
        const Graph graph(writer.graph, fakePlugins());
        ASSERT_EQ(graph.order().size(), count);
        std::vector<uint32_t> position(count);
        for (uint32_t i = 0; i < count; ++i)
            position[graph.order()[i]] = i;
        for (const auto& edge : graph.edges())
            EXPECT_TRUE(edge.delayed || position[edge.source] < position[edge.target]);
    }
}

TEST(GraphCulling, WhatNoOutputNeedsIsDead)
{
    auto writer = pathTracer();
    writer.add("unused", "Blur", {{"image", "paths.radiance"}});
    Graph graph(writer.graph, fakePlugins());
    EXPECT_EQ(orderOf(graph), (Names{"gbuffer", "paths", "accumulate"}));
    EXPECT_FALSE(graph.find("unused")->live);
    EXPECT_TRUE(graph.find("paths")->live);
}

TEST(GraphCulling, WhatIsReadOneFrameLaterIsLive)
{
    Writer writer;
    writer.add("gbuffer", "GBuffer")
        .add("paths", "Paths", {{"surface", "gbuffer.surface"}, {"guide", "~fit.guide"}})
        .add("fit", "Fit", {{"vertices", "paths.vertices"}})
        .output("image", "paths.radiance");
    EXPECT_EQ(orderOf(Graph(writer.graph, fakePlugins())), (Names{"gbuffer", "paths", "fit"}));
}

TEST(GraphPlan, OnlyWhatIsReadIsAllocated)
{
    Writer writer;
    writer.add("gbuffer", "GBuffer")
        .add("paths", "Paths", {{"surface", "gbuffer.surface"}, {"guide", "~fit.guide"}})
        .add("blur", "Blur", {{"image", "paths.radiance"}, {"other", "gbuffer.normal"}})
        .add("fit", "Fit", {{"vertices", "paths.vertices"}})
        .add("dead", "Blur", {{"image", "blur.blurred"}})
        .output("image", "paths.radiance")
        .output("smooth", "blur.blurred");
    EXPECT_EQ(resourcesOf(Graph(writer.graph, fakePlugins())),
              (Names{"gbuffer.surface", "gbuffer.normal", "paths.radiance", "paths.vertices", "blur.blurred",
                     "fit.guide x2"}));
}

TEST(GraphPlan, BytesFollowTheImageUnlessFixed)
{
    EXPECT_EQ(image(3).bytes(10, 4), 480u);
    EXPECT_EQ((PortType{"Surface", 0, 48, {}}).bytes(10, 4), 1920u);
    EXPECT_EQ(fixedSize("Guide", [] { return 1024; }).bytes(10, 4), 1024u);
}

TEST(GraphKnobs, AreSetFromTheDescription)
{
    Graph graph(
        pathTracer({{"bounces", 3}, {"roughness", 0.3}, {"offset", -2}, {"cells", "screen"}, {"nee", false}}).graph,
        fakePlugins());
    EXPECT_EQ(graph.knob("paths.bounces").get(), 3);
    EXPECT_EQ(graph.knob("paths.roughness").get(), 0.3) << "a float prints as it was written";
    EXPECT_EQ(graph.knob("paths.offset").get(), -2);
    EXPECT_EQ(graph.knob("paths.cells").get(), "screen");
    EXPECT_EQ(graph.knob("paths.nee").get(), false);
    EXPECT_TRUE(graph.knob("paths.bounces").structural);
    EXPECT_FALSE(graph.knob("paths.roughness").structural);
}

TEST(GraphKnobs, AreSetFromText)
{
    Graph graph(pathTracer().graph, fakePlugins());
    const std::vector<std::pair<std::string, json>> cases{
        {"bounces=12", 12u}, {"offset=-5", -5},          {"roughness=1e-1", 0.1}, {"nee=False", false},
        {"nee=on", true},    {"cells=screen", "screen"}, {"note=", ""},           {"note=a=b", "a=b"}};
    for (const auto& [text, value] : cases) {
        const auto equals = text.find('=');
        graph.setKnobFromText("paths." + text.substr(0, equals), text.substr(equals + 1));
        EXPECT_EQ(graph.knob("paths." + text.substr(0, equals)).get(), value) << text;
    }
}

TEST(GraphKnobs, RefuseTextAndKeepTheirValue)
{
    Graph graph(pathTracer().graph, fakePlugins());
    const auto set = [&](const char* knob, const char* text) {
        return refusal([&] { graph.setKnobFromText(knob, text); });
    };
    const std::string pass = "pass 'paths' (Paths): ";
    EXPECT_EQ(set("paths.bounces", "8x"), pass + "knob 'bounces' must be a whole number from 0 to 64, not \"8x\"");
    EXPECT_EQ(set("paths.bounces", ""), pass + "knob 'bounces' must be a whole number from 0 to 64, not \"\"");
    EXPECT_EQ(set("paths.bounces", "99999999999999999999"),
              pass + "knob 'bounces' must be a whole number from 0 to 64, not \"99999999999999999999\"");
    EXPECT_EQ(set("paths.roughness", "nan"), pass + "knob 'roughness' must be a number from 0 to 0.9, not \"nan\"");
    EXPECT_EQ(set("paths.nee", "maybe"), pass + "knob 'nee' must be true or false, not \"maybe\"");
    EXPECT_EQ(set("paths.cells", "\xff"), pass + "knob 'cells' must be one of world, screen, not \"\xEF\xBF\xBD\"");
    EXPECT_EQ(graph.knob("paths.bounces").get(), 8);
    EXPECT_EQ(graph.knob("paths.cells").get(), "world");
}

TEST(GraphKnobs, UnknownPathsNameTheNearest)
{
    Graph graph(pathTracer().graph, fakePlugins());
    const auto set = [&](const char* knob) { return refusal([&] { graph.setKnob(knob, 1); }); };
    EXPECT_EQ(set("bounces"), "'bounces' names no knob; write PASS.KNOB, as in gbuffer.KNOB");
    EXPECT_EQ(set("path.bounces"),
              "graph 'Test' has no pass 'path'; passes: gbuffer, paths, accumulate; did you mean 'paths'?");
    EXPECT_EQ(set("paths.bounce"),
              "pass 'paths' (Paths) has no knob 'bounce'; knobs: bounces, roughness, offset, cells, "
              "note, nee; did you mean 'bounces'?");
    EXPECT_EQ(set("accumulate.speed"), "pass 'accumulate' (Accumulate) has no knob 'speed'; knobs: none");
}

TEST(GraphKnobs, EverywhereReachesEachPassThatHasIt)
{
    Graph graph(pathTracer().add("fit", "Fit", {{"vertices", "paths.vertices"}}).graph, fakePlugins());
    EXPECT_EQ(graph.setKnobEverywhere("bounces", 2), 2u);
    EXPECT_EQ(graph.knob("paths.bounces").get(), 2);
    EXPECT_EQ(graph.knob("fit.bounces").get(), 2);
    EXPECT_EQ(graph.setKnobEverywhere("bounce", 2), 0u);
}

TEST(GraphDescription, RoundTripsWithTheKnobsAsTheyAreNow)
{
    Graph graph(pathTracer({{"bounces", 3}}).add("fit", "Fit", {{"vertices", "paths.vertices"}}).graph, fakePlugins());
    graph.setKnobFromText("paths.roughness", "0.7");
    const json described = graph.description();
    EXPECT_EQ(
        described["passes"][1]["knobs"],
        (json{{"bounces", 3}, {"roughness", 0.7}, {"offset", 0}, {"cells", "world"}, {"note", ""}, {"nee", true}}));
    const Graph again(json::parse(described.dump()), fakePlugins());
    EXPECT_EQ(again.description(), described);
    EXPECT_EQ(resourcesOf(again), resourcesOf(graph));
    EXPECT_EQ(orderOf(again), orderOf(graph));
}

TEST(Describe, TablesHoldEveryPortAndKnob)
{
    EXPECT_EQ(describePass(*entry<Fit>("Fit"), TextFormat::plain), R"(Fit: A fake

  input     type          meaning
  vertices  PathVertices  Path vertices

  output  type   size    meaning
  guide   Guide  1024 B  Where to go

  knob     type  default  range    meaning
  bounces  uint  4        0 .. 64  How many to learn from
)");
    EXPECT_EQ(describePass(*entry<Fit>("Fit"), TextFormat::markdown), R"(| input | type | meaning |
| --- | --- | --- |
| vertices | PathVertices | Path vertices |

| output | type | size | meaning |
| --- | --- | --- | --- |
| guide | Guide | 1024 B | Where to go |

| knob | type | default | range | meaning |
| --- | --- | --- | --- | --- |
| bounces | uint | 4 | 0 .. 64 | How many to learn from |
)");
    EXPECT_EQ(refusal([] { describePass(*entry<Twice>("Twice"), TextFormat::plain); }),
              "pass type 'Twice' describes itself wrongly: it declares 'image' twice");
}

/// A byte changed, removed or doubled, or a stretch of the text cut out, one to four times.
std::string mutated(std::string text, std::mt19937& random)
{
    for (uint32_t i = 0, count = 1 + random() % 4; i < count && !text.empty(); ++i) {
        const size_t at = random() % text.size();
        switch (random() % 4) {
        case 0:
            text[at] = char(random());
            break;
        case 1:
            text.erase(at, 1);
            break;
        case 2:
            text.insert(at, 1, text[random() % text.size()]);
            break;
        default:
            text.erase(at, random() % 40);
        }
    }
    return text;
}

TEST(GraphFuzz, MutatedDescriptionsAreAcceptedOrRefusedInWords)
{
    const std::string original = pathTracer({{"bounces", 3}, {"roughness", 0.3}}).graph.dump();
    std::mt19937 random(11);
    uint32_t parsed = 0, refused = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        const auto description = json::parse(mutated(original, random), nullptr, false);
        if (description.is_discarded())
            continue;  // readGraphFile's matter: files_test.cpp
        ++parsed;
        const auto message = mistakes(description);
        refused += !message.empty();
        EXPECT_NE(message.find(": "), 0u);
    }
    EXPECT_GT(parsed, 2000u) << "the mutations must reach the checks";
    EXPECT_GT(refused, 1000u);
}

TEST(GraphDot, DrawsDelayedEdgesDashedAndDeadPassesDotted)
{
    Graph graph(pathTracer().add("unused", "Blur").graph, fakePlugins());
    EXPECT_EQ(graph.dot(), R"(digraph "Test" {
    node [shape=box];
    "gbuffer" [label="gbuffer\nGBuffer"];
    "paths" [label="paths\nPaths"];
    "accumulate" [label="accumulate\nAccumulate"];
    "unused" [label="unused\nBlur", style=dotted];
    "gbuffer" -> "paths" [label="surface -> surface"];
    "paths" -> "accumulate" [label="radiance -> direct"];
    "accumulate" -> "accumulate" [label="sums -> history", style=dashed, constraint=false];
    "output image" [label="image", shape=ellipse];
    "accumulate" -> "output image" [label="mean"];
}
)");
}

}  // namespace
}  // namespace restirpg::test
