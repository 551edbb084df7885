// Graph files, Python and JSON, good and bad, and plugin libraries, good and bad.
#include "core/error.h"
#include "core/nearest.h"
#include "core/paths.h"
#include "core/process.h"
#include "graph/graph.h"

#include <gtest/gtest.h>

#include <sys/stat.h>

#include <cstdlib>
#include <fstream>
#include <random>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

/// A fresh folder of this test's own; the working directory, so that messages show relative paths.
class GraphFile : public testing::Test {
protected:
    void SetUp() override
    {
        std::string pattern = (fs::temp_directory_path() / "restirpg-graph-XXXXXX").string();
        folder_ = mkdtemp(pattern.data());
        fs::current_path(folder_);
    }
    void TearDown() override
    {
        fs::current_path("/");
        fs::remove_all(folder_);
    }

    void write(const std::string& name, const std::string& text) { std::ofstream(folder_ / name) << text; }

    std::string refusal(const fs::path& file)
    {
        try {
            readGraphFile(file);
        } catch (const Error& error) {
            return error.what();
        }
        return {};
    }

    /// The refusal of a Python graph file g.py with this text.
    std::string python(const std::string& text)
    {
        write("g.py", text);
        return refusal("g.py");
    }

    fs::path folder_;
};

const std::string IMPORT = "from restirpg import Graph, prev\n";

TEST_F(GraphFile, PythonIsEvaluatedWithPlaces)
{
    write("g.py", IMPORT + "graph = Graph('G')\n"
                           "a = graph.add('a', 'A', bounces=3, guide=None,\n"
                           "              history=prev('a.sums'))\n"
                           "graph.output('image', a.mean)\n");
    const auto description = readGraphFile("g.py");
    EXPECT_EQ(description, nlohmann::json::parse(R"({"name": "G", "file": "g.py",
        "passes": [{"name": "a", "type": "A", "file": "g.py", "line": 3, "knobs": {"bounces": 3},
                    "inputs": {"guide": null, "history": {"pass": "a", "output": "sums", "delayed": true}}}],
        "outputs": [{"name": "image", "pass": "a", "output": "mean", "file": "g.py", "line": 5}]})"));
}

TEST_F(GraphFile, WhatPythonPrintsDoesNotSpoilTheDescription)
{
    EXPECT_EQ(python(IMPORT + "print('hello')\ngraph = Graph('G')\n"), "");
}

TEST_F(GraphFile, PythonMistakesAreOneLocatedLine)
{
    EXPECT_EQ(python(IMPORT + "graph = Grap('G')\n"), "g.py:2: NameError: name 'Grap' is not defined");
    EXPECT_EQ(python("x = (\n"), "g.py:1: SyntaxError: '(' was never closed");
    EXPECT_EQ(python("import sys\nsys.exit(0)\n"), "g.py:2: SystemExit: 0");
    EXPECT_EQ(python(""), "g.py:1: the file has no variable 'graph'; end it with graph = ..., a restirpg.Graph");
    EXPECT_EQ(python("graph = 3\n"),
              "g.py:1: the file has a int in its variable 'graph'; end it with graph = ..., a restirpg.Graph");
}

TEST_F(GraphFile, ALoopWithoutEndIsEndedAndLocated)
{
    setenv("RESTIRPG_GRAPH_SECONDS", "1", 1);
    const std::string said = ": evaluating the graph file takes more than 1 s; look for a loop that does not end";
    const auto deaf = python(
        IMPORT + "def f():\n    while True:\n        try:\n            pass\n        except:\n            pass\nf()\n");
    EXPECT_TRUE(deaf.starts_with("g.py:") && deaf.ends_with(said) && deaf[5] >= '3' && deaf[5] <= '6') << deaf;
    EXPECT_EQ(python("import time\n\ntime.sleep(1000)\n"), "g.py:3" + said);
    // In one operation that takes longer.
    const auto busy = python("10 ** 10 ** 9\n");
    EXPECT_TRUE(busy.starts_with("g.py:") && busy.ends_with(said)) << busy;
    for (const std::string wrong : {"10m", "abc", "0", "-1", "1.5", "99999999999"}) {
        setenv("RESTIRPG_GRAPH_SECONDS", wrong.c_str(), 1);
        EXPECT_EQ(python(""), "RESTIRPG_GRAPH_SECONDS=" + wrong + ": give a whole number of seconds from 1 to 1000000");
    }
    unsetenv("RESTIRPG_GRAPH_SECONDS");
}

TEST_F(GraphFile, AFileThatPrintsWithoutEndIsEnded)
{
    EXPECT_EQ(python("while True:\n    print('x' * 100000)\n"),
              "g.py: the graph file prints more than 16 MiB while it is evaluated; let it print less");
}

TEST_F(GraphFile, AGraphIsBounded)
{
    EXPECT_EQ(python(IMPORT + "graph = Graph('G')\nfor i in range(100000):\n    graph.add(f'p{i}', 'P')\n"),
              "g.py:4: a graph has at most 1000 passes");
    EXPECT_EQ(python("import os\nbytes(os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') // 2)\n"),
              "g.py:2: MemoryError");
    std::string passes;
    for (int i = 0; i < 100000; ++i)
        passes += (i ? "," : "") + std::string(R"({"name":"p","type":"P"})");
    write("g.json", R"({"name":"G","passes":[)" + passes + "]}");
    EXPECT_EQ(refusal("g.json"), "g.json: \"passes\" has 100000 elements; a graph has at most 1000");
    passes.clear();
    for (int i = 0; i < 1000; ++i)
        passes += (i ? "," : "") + std::string("7");
    write("g.json", R"({"name":"G","passes":[)" + passes + "]}");
    EXPECT_TRUE(refusal("g.json").ends_with("g.json: pass 49 is not an object\nand 950 more mistakes"))
        << refusal("g.json");
    mkfifo("pipe.json", 0600);
    EXPECT_EQ(refusal("pipe.json"), "pipe.json: cannot read the graph file: it is a pipe or a device");
}

TEST_F(GraphFile, NamesInMessagesAreOneLineOfText)
{
    write("g.json", R"({"name":"G","passes":[{"name":"a\u001b]0;b\nc","type":"P"}]})");
    EXPECT_EQ(refusal("g.json").find('\x1b'), std::string::npos);
    EXPECT_EQ(refusal("g\x1b[31m\n\xff.json"),
              "g\\x1b[31m\\n\\xff.json: cannot read the graph file: No such file or directory");
    EXPECT_EQ(python("raise ValueError('a\\x1b[31mb')\n"), "g.py:1: ValueError: a\\x1b[31mb");
}

TEST_F(GraphFile, AnInterpreterThatDiesIsNamed)
{
    EXPECT_NE(python("import os\nos.abort()\n").find("ended with code 134 while evaluating the graph file"),
              std::string::npos);
}

TEST_F(GraphFile, AMissingInterpreterIsNamed)
{
    write("g.py", IMPORT);
    setenv("RESTIRPG_PYTHON", "/no/such/python3", 1);
    const auto message = refusal("g.py");
    unsetenv("RESTIRPG_PYTHON");
    EXPECT_EQ(message,
              "g.py: cannot start /no/such/python3: No such file or directory; RESTIRPG_PYTHON names the interpreter");
}

TEST_F(GraphFile, AnInterpreterThatIsTooOldIsNamed)
{
    write("g.py", IMPORT);
    write("python3", "#!/bin/sh\necho 'Unknown option: -P\nusage: python3 [option] ...' >&2\nexit 2\n");
    fs::permissions("python3", fs::perms::owner_all);
    setenv("RESTIRPG_PYTHON", "./python3", 1);
    const auto message = refusal("g.py");
    unsetenv("RESTIRPG_PYTHON");
    EXPECT_EQ(message, "g.py: ./python3 is older than Python 3.11; RESTIRPG_PYTHON names another");
}

/// The current folder may be anybody's; that of the graph file has its modules.
TEST_F(GraphFile, ModulesOfTheCurrentFolderAreNotImported)
{
    fs::create_directory("graphs");
    write("graphs/common.py", "NAME = 'n'\n");
    write("graphs/g.py", IMPORT + "from common import NAME\ngraph = Graph(NAME)\n"
                                  "graph.output('image', graph.add('a', 'GBuffer').albedo)\n");
    write("json.py", "raise SystemExit('json.py of the current folder was run')\n");
    for (const char* inherited : {(const char*)nullptr, ""}) {  // an empty entry of PYTHONPATH is the current folder
        const char* const before = std::getenv("PYTHONPATH");
        const std::string kept = before ? before : "";
        inherited ? setenv("PYTHONPATH", inherited, 1) : unsetenv("PYTHONPATH");
        EXPECT_EQ(refusal("graphs/g.py"), "");
        before ? setenv("PYTHONPATH", kept.c_str(), 1) : unsetenv("PYTHONPATH");
    }
}

TEST_F(GraphFile, UnreadableFilesAreNamed)
{
    fs::create_directory("folder.py");
    write("g.txt", "");
    write("empty.json", " \n");
    EXPECT_EQ(refusal("none.py"), "none.py: cannot read the graph file: No such file or directory");
    EXPECT_EQ(refusal("folder.py"), "folder.py: cannot read the graph file: Is a directory");
    EXPECT_EQ(refusal("g.txt"), "g.txt: a graph file ends in .py or .json");
    EXPECT_EQ(refusal("empty.json"),
              "empty.json: the file is empty; a graph is an object with \"name\", \"passes\" and \"outputs\"");
}

TEST_F(GraphFile, BrokenJsonIsLocated)
{
    write("g.json", "{\"name\": \"x\",\n \"passes\": [,]\n}");
    EXPECT_EQ(refusal("g.json"), "g.json:2: not JSON: syntax error while parsing value - unexpected ','; "
                                 "expected '[', '{', or a literal");
    write("g.json", "{\"name\": \"\xff\"}");
    EXPECT_TRUE(refusal("g.json").starts_with("g.json:1: not JSON: ")) << refusal("g.json");
    write("g.json", std::string(100000, '['));
    EXPECT_EQ(refusal("g.json"), "g.json: not a graph: nested deeper than 64 levels");
    write("g.json", "{}");
    EXPECT_EQ(refusal("g.json"), "g.json: the graph needs a text \"name\"");
}

TEST_F(GraphFile, DamagedJsonIsReadOrRefusedInOneLine)
{
    const std::string original =
        R"({"name": "G", "passes": [{"name": "a", "type": "A", "inputs": {"history": {"pass": "a",
        "output": "sums", "delayed": true}}, "knobs": {"x": -1.5e3}}],
        "outputs": [{"name": "i", "pass": "a", "output": "m"}]})";
    std::mt19937 random(5);
    uint32_t refused = 0;
    for (int trial = 0; trial < 500; ++trial) {
        std::string text = original.substr(0, random() % 5 ? original.size() : random() % original.size());
        for (uint32_t i = 0, count = random() % 4; i < count && !text.empty(); ++i)
            text[random() % text.size()] ^= char(1 << random() % 8);
        write("g.json", text);
        const auto message = refusal("g.json");
        refused += !message.empty();
        EXPECT_TRUE(message.empty() || message.starts_with("g.json:")) << message;
    }
    EXPECT_GT(refused, 100u);
}

/// The plugin folder built for these tests, and a fresh one with a file that is no library.
class PluginLibraries : public GraphFile {
protected:
    void SetUp() override
    {
        GraphFile::SetUp();
        write("restirpg-pass-Garbage.so", "not a library");
        setenv("RESTIRPG_PLUGIN_PATH", (std::string(TEST_PLUGINS) + ":/no/such/folder:" + folder_.string()).c_str(), 1);
    }
    void TearDown() override
    {
        unsetenv("RESTIRPG_PLUGIN_PATH");
        GraphFile::TearDown();
    }
};

TEST_F(PluginLibraries, AGoodOneIsFoundAndDescribesItself)
{
    const Plugins plugins;
    const auto* good = plugins.find("Good");
    ASSERT_NE(good, nullptr) << plugins.problem("Good");
    Interface interface;
    good->entry->create()->describe(interface);
    EXPECT_STREQ(good->entry->meaning, "Does nothing, well");
    EXPECT_EQ(good->library, fs::path(TEST_PLUGINS) / "restirpg-pass-Good.so");
}

TEST_F(PluginLibraries, BrokenOnesAreNamedWhenAskedForAndSpoilNoOther)
{
    const Plugins plugins;
    const auto problem = [&](const std::string& name) {
        EXPECT_EQ(plugins.find(name), nullptr);
        return plugins.problem(name);
    };
    const std::string folder = TEST_PLUGINS;
    EXPECT_EQ(problem("WrongAbi"), folder + "/restirpg-pass-WrongAbi.so: built for plugin ABI " +
                                       std::to_string(PLUGIN_ABI + 1) + ", this framework has " +
                                       std::to_string(PLUGIN_ABI) + "; rebuild the pass");
    EXPECT_EQ(problem("Empty"), folder + "/restirpg-pass-Empty.so: it exports no pass; its source must end with "
                                         "RESTIRPG_PASS(Empty, \"...\")");
    EXPECT_EQ(problem("Misnamed"), folder + "/restirpg-pass-Misnamed.so: it contains the pass 'Renamed'; name the file "
                                            "restirpg-pass-Renamed.so");
    EXPECT_EQ(problem("Nameless"), folder + "/restirpg-pass-Nameless.so: its entry lacks a name; end its source with "
                                            "RESTIRPG_PASS(Nameless, \"...\")");
    EXPECT_EQ(problem("Meaningless"),
              folder + "/restirpg-pass-Meaningless.so: its entry lacks a meaning; end its source with "
                       "RESTIRPG_PASS(Meaningless, \"...\")");
    EXPECT_EQ(problem("Uncreated"),
              folder + "/restirpg-pass-Uncreated.so: its entry lacks a function that creates the pass; end "
                       "its source with RESTIRPG_PASS(Uncreated, \"...\")");
    EXPECT_EQ(problem("Sourceless"),
              folder + "/restirpg-pass-Sourceless.so: its entry lacks the folder of its source; end its source "
                       "with RESTIRPG_PASS(Sourceless, \"...\")");
    EXPECT_TRUE(problem("Garbage").ends_with(
        "restirpg-pass-Garbage.so: file too short; rebuild the pass against this framework"))
        << problem("Garbage");
    EXPECT_EQ(problem("None"), "");
    EXPECT_NE(plugins.find("Good"), nullptr);
}

TEST_F(PluginLibraries, ABrokenOneIsAMistakeOfTheGraphThatAsksForIt)
{
    write("g.py", IMPORT + "graph = Graph('G')\ngraph.output('image', graph.add('a', 'Empty').mean)\n");
    try {
        const Graph graph(readGraphFile("g.py"), Plugins());
        FAIL() << "a broken plugin was accepted";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  "g.py:3: pass type 'Empty' cannot be loaded: " + std::string(TEST_PLUGINS) +
                      "/restirpg-pass-Empty.so: it exports no pass; its source must end with "
                      "RESTIRPG_PASS(Empty, \"...\")");
    }
}

TEST(Process, ReadsBothStreamsWhateverTheirSize)
{
    const auto result =
        runProcess({"sh", "-c", "head -c 300000 /dev/zero >&2; head -c 200000 /dev/zero; echo $GREETING; exit 3"},
                   {{"GREETING", "hello"}});
    EXPECT_EQ(result.exitCode, 3);
    EXPECT_EQ(result.errors.size(), 300000u);
    EXPECT_EQ(result.output.substr(200000), "hello\n");
}

TEST(Process, IsEndedAtItsLimit)
{
    const auto result = runProcess({"sh", "-c", "echo begun; exec sleep 1000"}, {}, std::chrono::milliseconds(300));
    EXPECT_TRUE(result.timedOut);
    EXPECT_EQ(result.output, "begun\n");
    EXPECT_TRUE(runProcess({"sh", "-c", "exec sleep 1000 >&- 2>&-"}, {}, std::chrono::milliseconds(300)).timedOut);
    EXPECT_FALSE(runProcess({"true"}, {}, std::chrono::seconds(100)).timedOut);
    EXPECT_FALSE(runProcess({"sleep", "0.1"}, {}, std::chrono::hours(1000)).timedOut)
        << "more milliseconds than an int";
}

/// Sets a variable of the environment, or unsets it, until the end of its scope.
class Variable {
public:
    Variable(const char* name, const char* value) : name_(name)
    {
        if (const char* old = std::getenv(name))
            old_ = old;
        value ? setenv(name, value, 1) : unsetenv(name);
    }
    ~Variable() { old_ ? setenv(name_, old_->c_str(), 1) : unsetenv(name_); }

private:
    const char* name_;
    std::optional<std::string> old_;
};

TEST_F(GraphFile, ThereNeedBeNoCache)
{
    const Variable given("RESTIRPG_CACHE_DIR", nullptr), xdg("XDG_CACHE_HOME", nullptr);
    {
        const Variable home("HOME", nullptr);
        EXPECT_EQ(cacheFolder(), "");
    }
    const Variable home("HOME", folder_.c_str());
    EXPECT_EQ(cacheFolder(), folder_ / ".cache/restirpg");
}

TEST_F(GraphFile, WhatWasReadIsNotWritten)
{
    write("input.exr", "");
    fs::create_directory("sub");
    fs::create_symlink("input.exr", "link.exr");
    fs::create_hard_link("input.exr", "hard.exr");
    const auto refused = [](const char* output) {
        try {
            refuseInput(output, {"none.glb", "input.exr"});
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    for (const char* name : {"input.exr", "./sub/../input.exr", "link.exr", "hard.exr"})
        EXPECT_EQ(refused(name),
                  std::string(name) + ": cannot write: it is the file input.exr, which was read; choose another name");
    EXPECT_EQ(refused("other.exr"), "");
}

TEST(Nearest, CountsEdits)
{
    EXPECT_EQ(editDistance("guiding", "guide"), 3u);
    EXPECT_EQ(editDistance("", "abc"), 3u);
    EXPECT_EQ(editDistance("same", "same"), 0u);
    EXPECT_EQ(nearest("guiding", {"surface", "guide"}), "guide");
    EXPECT_EQ(nearest("zzz", {"surface", "guide"}), "");
    EXPECT_EQ(nearest("x", {}), "");
}

}  // namespace
}  // namespace restirpg
