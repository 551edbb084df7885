// Every mistake a graph file can hold, with the exact text a user reads.
#include "describing.h"

#include <gtest/gtest.h>

namespace restirpg::test {
namespace {

TEST(GraphMistakes, ACorrectGraphHasNone)
{
    EXPECT_EQ(mistakes(pathTracer().graph), "");
}

TEST(GraphMistakes, UnknownPassTypeListsThePassesAndTheNearest)
{
    EXPECT_EQ(mistakes(pathTracer().add("more", "Path").graph),
              "g.py:5: there is no pass type 'Path'\n"
              "    pass types: Accumulate, Apart, Blur, Fit, GBuffer, Nameless, Paths, Reuse, Twice        did you "
              "mean 'Paths'?");
}

TEST(GraphMistakes, DuplicatePassNameNamesTheFirst)
{
    EXPECT_EQ(mistakes(pathTracer().add("paths", "Blur").graph),
              "g.py:5: pass 'paths' is added twice, first at g.py:2");
}

TEST(GraphMistakes, UnknownInputListsTheInputsAndTheNearest)
{
    EXPECT_EQ(
        mistakes(pathTracer().add("more", "Paths", {{"surface", "gbuffer.surface"}, {"guiding", "~fit.guide"}}).graph),
        "g.py:5: pass 'more' (Paths) has no input 'guiding'\n"
        "    inputs: surface, guide (optional)        did you mean 'guide'?");
}

TEST(GraphMistakes, UnknownInputLeftUnwiredIsAMistakeToo)
{
    EXPECT_EQ(mistakes(pathTracer().add("more", "Blur", {{"imago", nullptr}}).graph),
              "g.py:5: pass 'more' (Blur) has no input 'imago'\n"
              "    inputs: image (optional), other (optional)        did you mean 'image'?");
}

TEST(GraphMistakes, UnknownKnobListsTheKnobsAndTheNearest)
{
    EXPECT_EQ(mistakes(pathTracer({{"bounce", 3}}).graph),
              "g.py:2: pass 'paths' (Paths) has no knob 'bounce'\n"
              "    knobs: bounces, roughness, offset, cells, note, nee        did you mean 'bounces'?");
    EXPECT_EQ(mistakes(pathTracer().add("more", "Blur", {}, {{"radius", 3}}).graph),
              "g.py:5: pass 'more' (Blur) has no knob 'radius'\n"
              "    knobs: none");
}

TEST(GraphMistakes, AnOutputWiredToAKnobIsToldApart)
{
    EXPECT_EQ(
        mistakes(pathTracer().add("fit", "Fit", {{"vertices", "paths.vertices"}, {"bounces", "gbuffer.depth"}}).graph),
        "g.py:5: 'bounces' of pass 'fit' (Fit) is a knob: give it a value, not an output of a pass");
    EXPECT_EQ(mistakes(pathTracer().add("fit", "Fit", {{"vertices", "paths.vertices"}, {"bounces", nullptr}}).graph),
              "g.py:5: 'bounces' of pass 'fit' (Fit) is a knob: give it a value, not None");
}

TEST(GraphMistakes, AValueGivenToAnInputIsToldApart)
{
    EXPECT_EQ(mistakes(pathTracer().add("fit", "Fit", {}, {{"vertices", "paths.vertices"}}).graph),
              "g.py:5: 'vertices' of pass 'fit' (Fit) is an input: wire it to an output of a pass\n"
              "    outputs of type PathVertices: paths.vertices");
}

TEST(GraphMistakes, UnknownOutputOfAPassListsItsOutputs)
{
    EXPECT_EQ(mistakes(pathTracer().add("blur", "Blur", {{"image", "paths.radiant"}}).graph),
              "g.py:5: input 'image' of pass 'blur' (Blur) reads paths.radiant, but pass 'paths' (Paths) has no output "
              "'radiant'\n"
              "    outputs: radiance, vertices        did you mean 'radiance'?");
}

TEST(GraphMistakes, UnknownPassOfAnEdgeListsThePasses)
{
    EXPECT_EQ(mistakes(pathTracer().add("blur", "Blur", {{"image", "~path.radiance"}}).graph),
              "g.py:5: input 'image' of pass 'blur' (Blur) reads prev(\"path.radiance\"), but there is no pass 'path'\n"
              "    passes: gbuffer, paths, accumulate, blur        did you mean 'paths'?");
}

TEST(GraphMistakes, RequiredInputUnwiredNamesWhatFits)
{
    EXPECT_EQ(mistakes(pathTracer().add("fit", "Fit").graph),
              "g.py:5: pass 'fit' (Fit) needs its input 'vertices' wired\n"
              "    outputs of type PathVertices: paths.vertices");
    EXPECT_EQ(mistakes(pathTracer().add("fit", "Fit", {{"vertices", nullptr}}).graph),
              "g.py:5: pass 'fit' (Fit) needs its input 'vertices' wired\n"
              "    outputs of type PathVertices: paths.vertices");
}

TEST(GraphMistakes, InputsThatGoTogetherAreAllWiredOrNone)
{
    EXPECT_EQ(mistakes(pathTracer().add("reuse", "Reuse", {{"motion", "gbuffer.normal"}}).graph),
              "g.py:5: pass 'reuse' (Reuse) has 'motion' wired, but not 'history'\n"
              "    wire all of motion, history, or none");
    EXPECT_EQ(mistakes(pathTracer().add("reuse", "Reuse", {{"motion", "gbuffer.normal"}, {"history", nullptr}}).graph),
              "g.py:5: pass 'reuse' (Reuse) has 'motion' wired, but not 'history'\n"
              "    wire all of motion, history, or none");
    EXPECT_EQ(mistakes(pathTracer()
                           .add("reuse", "Reuse")
                           .add("all", "Reuse", {{"motion", "gbuffer.normal"}, {"history", "~all.merged"}})
                           .graph),
              "");
    EXPECT_EQ(mistakes(pathTracer().add("apart", "Apart", {{"image", "gbuffer.normal"}}).graph),
              "g.py:5: pass 'apart' (Apart) describes itself wrongly: 'image' is no optional input, or not yet: "
              "declare it before together()");
}

TEST(GraphMistakes, AChoiceBeginsWithOneOfItsNames)
{
    EXPECT_EQ(
        mistakes(pathTracer().add("nameless", "Nameless").graph),
        "g.py:5: pass 'nameless' (Nameless) describes itself wrongly: the choice 'curve' begins with a value that "
        "has no name");
}

TEST(GraphMistakes, TypeMismatchNamesBothTypesAndWhatFits)
{
    EXPECT_EQ(mistakes(pathTracer().add("blur", "Blur", {{"image", "gbuffer.depth"}}).graph),
              "g.py:5: input 'image' of pass 'blur' (Blur) takes Image3, but gbuffer.depth is Image1\n"
              "    outputs of type Image3: gbuffer.normal, paths.radiance, accumulate.mean, blur.blurred");
}

TEST(GraphMistakes, AnUndelayedCycleIsPrinted)
{
    Writer writer;
    writer.add("a", "Blur", {{"image", "c.blurred"}, {"other", "~b.blurred"}})
        .add("b", "Blur", {{"image", "a.blurred"}})
        .add("c", "Blur", {{"other", "b.blurred"}})
        .output("image", "c.blurred");
    EXPECT_EQ(mistakes(writer.graph), "g.py:1: cycle without a delay: a -> b -> c -> a\n"
                                      "    wire one of these inputs with prev(): b.image, c.other, a.image");
}

TEST(GraphMistakes, ASelfLoopIsACycle)
{
    Writer writer;
    writer.add("before", "Blur").add("a", "Blur", {{"image", "a.blurred"}}).output("image", "a.blurred");
    EXPECT_EQ(mistakes(writer.graph), "g.py:2: cycle without a delay: a -> a\n"
                                      "    wire one of these inputs with prev(): a.image");
}

TEST(GraphMistakes, TwoCyclesAreBothPrinted)
{
    Writer writer;
    writer.add("a", "Blur", {{"image", "a.blurred"}})
        .add("b", "Blur", {{"image", "c.blurred"}, {"other", "a.blurred"}})
        .add("c", "Blur", {{"image", "b.blurred"}})
        .output("image", "c.blurred");
    EXPECT_EQ(mistakes(writer.graph), "g.py:1: cycle without a delay: a -> a\n"
                                      "    wire one of these inputs with prev(): a.image\n"
                                      "g.py:2: cycle without a delay: b -> c -> b\n"
                                      "    wire one of these inputs with prev(): c.image, b.image");
}

TEST(GraphMistakes, KnobsRefuseWrongTypesRangesAndChoices)
{
    const auto wrong = [](const char* knob, json value) {
        return mistakes(pathTracer({{knob, std::move(value)}}).graph);
    };
    const std::string place = "g.py:2: pass 'paths' (Paths): ";
    EXPECT_EQ(wrong("bounces", 65), place + "knob 'bounces' must be a whole number from 0 to 64, not 65");
    EXPECT_EQ(wrong("bounces", -1), place + "knob 'bounces' must be a whole number from 0 to 64, not -1");
    EXPECT_EQ(wrong("bounces", 2.5), place + "knob 'bounces' must be a whole number from 0 to 64, not 2.5");
    EXPECT_EQ(wrong("bounces", true), place + "knob 'bounces' must be a whole number from 0 to 64, not true");
    EXPECT_EQ(wrong("bounces", "8"), place + "knob 'bounces' must be a whole number from 0 to 64, not \"8\"");
    EXPECT_EQ(wrong("bounces", json::array({1})),
              place + "knob 'bounces' must be a whole number from 0 to 64, not an array");
    EXPECT_EQ(wrong("offset", -6), place + "knob 'offset' must be a whole number from -5 to 5, not -6");
    EXPECT_EQ(wrong("roughness", 0.91), place + "knob 'roughness' must be a number from 0 to 0.9, not 0.91");
    EXPECT_EQ(wrong("nee", 1), place + "knob 'nee' must be true or false, not 1");
    EXPECT_EQ(wrong("note", 1), place + "knob 'note' must be text, not 1");
    EXPECT_EQ(wrong("cells", "wordl"),
              place + "knob 'cells' must be one of world, screen, not \"wordl\"; did you mean 'world'?");
    EXPECT_EQ(wrong("roughness", 0.9), "") << "bounds are inclusive, as written";
}

TEST(GraphMistakes, AGraphNeedsAnOutput)
{
    EXPECT_EQ(mistakes(Writer().add("gbuffer", "GBuffer").graph),
              "g.py: the graph has no output; add one, as in g.output(\"image\", accumulate.mean)");
}

TEST(GraphMistakes, OutputsMustExistAndDiffer)
{
    EXPECT_EQ(mistakes(pathTracer().output("image", "gbuffer.normal").output("z", "gbuffer.dept").graph),
              "g.py:5: output 'image' is added twice\n"
              "g.py:6: output 'z' reads gbuffer.dept, but pass 'gbuffer' (GBuffer) has no output 'dept'\n"
              "    outputs: surface, normal, depth        did you mean 'depth'?");
}

TEST(GraphMistakes, AnOutputThatIsNoImageIsAllowed)
{
    EXPECT_EQ(mistakes(pathTracer().output("hits", "gbuffer.surface").graph), "");
}

TEST(GraphMistakes, APassThatDescribesItselfWronglyIsNamed)
{
    EXPECT_EQ(mistakes(pathTracer().add("twice", "Twice").graph),
              "g.py:5: pass 'twice' (Twice) describes itself wrongly: it declares 'image' twice");
}

TEST(GraphMistakes, AreCollectedWithoutFollowingOnes)
{
    Writer writer;
    writer.add("gbuffer", "Gbuffer")
        .add("paths", "Paths", {{"surface", "gbuffer.surface"}}, {{"bounces", 100}, {"bounce", 1}})
        .output("image", "paths.radiance")
        .output("depth", "gbuffer.depth");
    EXPECT_EQ(mistakes(writer.graph),
              "g.py:1: there is no pass type 'Gbuffer'\n"
              "    pass types: Accumulate, Apart, Blur, Fit, GBuffer, Nameless, Paths, Reuse, Twice        did you "
              "mean 'GBuffer'?\n"
              "g.py:2: pass 'paths' (Paths) has no knob 'bounce'\n"
              "    knobs: bounces, roughness, offset, cells, note, nee        did you mean 'bounces'?\n"
              "g.py:2: pass 'paths' (Paths): knob 'bounces' must be a whole number from 0 to 64, not 100");
}

TEST(GraphMistakes, JsonOfTheWrongShapeIsNamedByPlace)
{
    EXPECT_EQ(mistakes(json::array()), "graph: a graph is an object with \"name\", \"passes\" and \"outputs\"");
    EXPECT_EQ(mistakes(json::object()), "graph: the graph needs a text \"name\"");
    EXPECT_EQ(mistakes({{"name", "x"}}),
              "graph: the graph has no output; add one, as in g.output(\"image\", accumulate.mean)");
    EXPECT_EQ(mistakes({{"name", "x"}, {"passes", 3}, {"outputs", "none"}}), "graph: \"passes\" is not an array\n"
                                                                             "graph: \"outputs\" is not an array");
    const json bad = json::array(
        {3,
         {{"type", "Blur"}},
         {{"name", "a b"}, {"type", 7}},
         {{"name", "c"}, {"type", "Blur"}, {"inputs", json::array()}, {"knobs", 1}},
         {{"name", "d"}, {"type", "Blur"}, {"inputs", {{"image", "c.blurred"}, {"other", {{"pass", "c"}}}}}},
         {{"name", "e"}, {"type", "Blur"}, {"inputs", {{"image", {{"pass", "c"}, {"output", "d"}, {"delayed", 1}}}}}}});
    EXPECT_EQ(
        mistakes({{"name", "x"}, {"file", "h.json"}, {"passes", bad}, {"outputs", json::array({0, {{"name", "o"}}})}}),
        "h.json: pass 0 is not an object\n"
        "h.json: pass 1 needs a text \"name\"\n"
        "h.json: pass 2 has \"name\": \"a b\", which must be letters, digits and underscores\n"
        "h.json: pass 2 needs a text \"type\"\n"
        "h.json: pass 'c' has \"inputs\" that is not an object\n"
        "h.json: pass 'c' has \"knobs\" that is not an object\n"
        "h.json: input 'image' of pass 'd' is neither null nor an object with \"pass\" and \"output\"\n"
        "h.json: input 'other' of pass 'd' needs a text \"output\"\n"
        "h.json: input 'image' of pass 'e' has a \"delayed\" that is neither true nor false\n"
        "h.json: output 0 is not an object\n"
        "h.json: output 1 needs a text \"pass\"\n"
        "h.json: output 1 needs a text \"output\"");
}

TEST(GraphMistakes, ADelayedOutputIsRefused)
{
    EXPECT_EQ(mistakes(pathTracer().output("old", "~gbuffer.normal").graph), "g.py:5: output 'old' cannot be delayed");
}

}  // namespace
}  // namespace restirpg::test
