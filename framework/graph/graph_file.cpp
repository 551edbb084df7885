// Reading a graph file, Python or JSON.
#include "graph/graph.h"

#include "core/error_kinds.h"
#include "core/log.h"
#include "core/paths.h"
#include "core/process.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

/// A description nests 5 deep; copying JSON recurses, so that a hostile file could exhaust the stack.
constexpr int MAXIMUM_DEPTH = 64;
/// restirpg/evaluate.py ends a file in time and says where it was. This is for one that does not even let itself be
/// interrupted.
constexpr std::chrono::seconds GRACE(3);
constexpr uint64_t LARGEST_FILE = 16u << 20;

/// That a Python file may take: RESTIRPG_GRAPH_SECONDS, else 30.
std::chrono::seconds timeLimit()
{
    constexpr int MOST = 1000000;
    const char* given = std::getenv("RESTIRPG_GRAPH_SECONDS");
    if (!given || !*given)
        return std::chrono::seconds(30);
    const char* const end = given + std::strlen(given);
    int seconds = 0;
    const auto read = std::from_chars(given, end, seconds);
    if (read.ec != std::errc() || read.ptr != end || seconds < 1 || seconds > MOST)
        fail("RESTIRPG_GRAPH_SECONDS={}: give a whole number of seconds from 1 to {}", given, MOST);
    return std::chrono::seconds(seconds);
}

std::string readText(const fs::path& file)
{
    std::error_code unknown;
    if (fs::exists(file, unknown) && !fs::is_directory(file) && !fs::is_regular_file(file))
        fail("{}: cannot read the graph file: it is a pipe or a device", file.string());
    std::ifstream stream(file, std::ios::binary);
    std::ostringstream text;
    if (!stream || fs::is_directory(file))
        failToRead(file, "{}: cannot read the graph file: {}", file.string(), std::strerror(stream ? EISDIR : errno));
    if (const auto bytes = fs::file_size(file, unknown); bytes > LARGEST_FILE)
        fail("{}: cannot read the graph file: it has {} bytes, a graph at most {}", file.string(), bytes, LARGEST_FILE);
    text << stream.rdbuf();
    return text.str();
}

nlohmann::json parseJson(const std::string& text, const fs::path& file)
{
    if (text.find_first_not_of(" \t\r\n") == std::string::npos)
        fail("{}: the file is empty; a graph is an object with \"name\", \"passes\" and \"outputs\"", file.string());
    try {
        return nlohmann::json::parse(text, [&](int depth, nlohmann::json::parse_event_t, nlohmann::json&) {
            if (depth > MAXIMUM_DEPTH)
                fail("{}: not a graph: nested deeper than {} levels", file.string(), MAXIMUM_DEPTH);
            return true;
        });
    } catch (const nlohmann::json::exception& error) {
        // "[json.exception.parse_error.101] parse error at line 1, column 2: syntax error while ..."
        std::string reason = error.what();
        if (const auto end = reason.find(": "); end != std::string::npos)
            reason.erase(0, end + 2);
        uint32_t line = 1;
        if (const auto* syntax = dynamic_cast<const nlohmann::json::parse_error*>(&error))
            line += uint32_t(std::count(text.begin(), text.begin() + long(std::min(syntax->byte, text.size())), '\n'));
        fail("{}:{}: not JSON: {}", file.string(), line, reason);
    }
}

/// What a Python graph file describes, evaluated in a process of its own.
std::string evaluate(const fs::path& file)
{
    auto command = pythonModule("restirpg.evaluate");
    const auto limit = timeLimit();
    command.insert(command.end(), {file.string(), std::to_string(limit.count())});
    const auto result = [&] {
        try {
            // Leave no __pycache__ in the user's folder.
            return runProcess(
                command,
                {{"PYTHONPATH", pythonPath()}, {"PYTHONIOENCODING", "utf-8"}, {"PYTHONDONTWRITEBYTECODE", "1"}},
                limit + GRACE);
        } catch (const Error& error) {
            fail("{}: {}; RESTIRPG_PYTHON names the interpreter", file.string(), error.what());
        }
    }();
    if (result.timedOut)
        fail("{}: evaluating the graph file takes more than {} s; look for a loop that does not end", file.string(),
             limit.count());
    if (result.tooMuch)
        fail("{}: the graph file prints more than {} MiB while it is evaluated; let it print less", file.string(),
             MOST_PRINTED >> 20);
    std::string errors = result.errors;
    while (!errors.empty() && errors.back() == '\n')
        errors.pop_back();
    if (errors.rfind("Unknown option: -P", 0) == 0)
        fail("{}: {} is older than Python 3.11; RESTIRPG_PYTHON names another", file.string(), command.front());
    if (result.exitCode == 2 && !errors.empty())
        throw Error(errors);
    if (result.exitCode != 0)
        fail("{}: {} ended with code {} while evaluating the graph file{}{}", file.string(),
             pythonInterpreter().string(), result.exitCode, errors.empty() ? "" : ": ",
             errors.substr(errors.rfind('\n') + 1));
    if (!errors.empty())
        logInfo(errors);  // what the file printed
    return result.output;
}

}  // namespace

nlohmann::json readGraphFile(const fs::path& file)
{
    std::string text = readText(file);
    if (file.extension() == ".py")
        text = evaluate(file);
    else if (file.extension() != ".json")
        fail("{}: a graph file ends in .py or .json", file.string());
    auto description = parseJson(text, file);
    Mistakes mistakes;
    parseDescription(description, file.string(), mistakes);
    mistakes.raise();
    description.emplace("file", file.string());
    return description;
}

}  // namespace restirpg
