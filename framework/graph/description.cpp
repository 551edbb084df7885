#include "graph/description.h"

#include "core/error.h"
#include "graph/knob.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

namespace restirpg {
namespace {

using nlohmann::json;

constexpr size_t MOST_PASSES = 1000;  // ordering takes the square of their number, and no device has memory for more
constexpr size_t MOST_MISTAKES = 50;  // of which a message tells

/// Letters, digits and underscores: names become "pass.knob" on the command line and layers of an EXR.
bool isIdentifier(const std::string& name)
{
    const auto isWord = [](unsigned char c) { return c < 128 && (std::isalnum(c) || c == '_'); };
    return !name.empty() && !(name[0] >= '0' && name[0] <= '9') && std::all_of(name.begin(), name.end(), isWord);
}

/// Reads members of JSON objects, reporting what is missing or of the wrong type.
class Reader {
public:
    Reader(Mistakes& mistakes, std::string file) : mistakes_(mistakes), file_(std::move(file)) {}

    const std::string& file() const { return file_; }

    void wrong(const Location& where, const std::string& what) { mistakes_.add(where, what); }

    Location location(const json& object) const
    {
        Location result{file_, 0};
        if (const auto file = object.find("file"); file != object.end() && file->is_string())
            result.file = file->get<std::string>();
        if (const auto line = object.find("line"); line != object.end() && line->is_number_unsigned())
            result.line = line->get<uint32_t>();
        return result;
    }

    /// A required identifier, or nullopt with a mistake.
    std::optional<std::string> identifier(const json& object, const char* member, const Location& where,
                                          const std::string& what)
    {
        const auto found = object.find(member);
        if (found == object.end() || !found->is_string()) {
            wrong(where, fmt::format("{} needs a text \"{}\"", what, member));
            return std::nullopt;
        }
        const auto name = found->get<std::string>();
        if (!isIdentifier(name)) {
            wrong(where, fmt::format("{} has \"{}\": {}, which must be letters, digits and underscores", what, member,
                                     jsonText(*found)));
            return std::nullopt;
        }
        return name;
    }

    std::optional<DescribedPort> port(const json& object, const Location& where, const std::string& what)
    {
        const auto pass = identifier(object, "pass", where, what);
        const auto output = identifier(object, "output", where, what);
        if (!pass || !output)
            return std::nullopt;
        const auto delayed = object.find("delayed");
        if (delayed != object.end() && !delayed->is_boolean()) {
            wrong(where, what + " has a \"delayed\" that is neither true nor false");
            return std::nullopt;
        }
        return DescribedPort{*pass, *output, delayed != object.end() && delayed->get<bool>()};
    }

    /// The member that is an object, an empty one when it is absent; nullptr with a mistake when it is something else.
    const json* objectMember(const json& object, const char* member, const Location& where, const std::string& what)
    {
        static const json EMPTY = json::object();
        const auto found = object.find(member);
        if (found == object.end())
            return &EMPTY;
        if (found->is_object())
            return &*found;
        wrong(where, fmt::format("{} has \"{}\" that is not an object", what, member));
        return nullptr;
    }

private:
    Mistakes& mistakes_;
    std::string file_;
};

std::optional<DescribedPass> parsePass(const json& object, size_t index, Reader& reader)
{
    std::string what = fmt::format("pass {}", index);
    if (!object.is_object()) {
        reader.wrong({reader.file(), 0}, what + " is not an object");
        return std::nullopt;
    }
    DescribedPass pass;
    pass.location = reader.location(object);
    const auto name = reader.identifier(object, "name", pass.location, what);
    if (name)
        what = fmt::format("pass '{}'", *name);
    const auto type = reader.identifier(object, "type", pass.location, what);
    const auto* inputs = reader.objectMember(object, "inputs", pass.location, what);
    const auto* knobs = reader.objectMember(object, "knobs", pass.location, what);
    if (!name || !type || !inputs || !knobs)
        return std::nullopt;
    pass.name = *name;
    pass.type = *type;
    for (const auto& [input, source] : inputs->items()) {
        const std::string whatInput = fmt::format("input '{}' of pass '{}'", input, pass.name);
        if (source.is_null())
            pass.inputs.emplace_back(input, std::nullopt);
        else if (!source.is_object())
            reader.wrong(pass.location, whatInput + " is neither null nor an object with \"pass\" and \"output\"");
        else if (const auto port = reader.port(source, pass.location, whatInput))
            pass.inputs.emplace_back(input, port);
    }
    for (const auto& [knob, value] : knobs->items())
        pass.knobs.emplace_back(knob, value);
    return pass;
}

std::optional<DescribedOutput> parseOutput(const json& object, size_t index, Reader& reader)
{
    const std::string what = fmt::format("output {}", index);
    if (!object.is_object()) {
        reader.wrong({reader.file(), 0}, what + " is not an object");
        return std::nullopt;
    }
    const Location where = reader.location(object);
    const auto port = reader.port(object, where, what);
    // An output may be called as the port that it shows: so are those that are asked for beside the graph's.
    const std::string path = port ? port->pass + "." + port->output : "";
    const auto name = object.value("name", json()) == path ? path : reader.identifier(object, "name", where, what);
    if (!name || !port)
        return std::nullopt;
    if (port->delayed) {
        reader.wrong(where, fmt::format("output '{}' cannot be delayed", *name));
        return std::nullopt;
    }
    return DescribedOutput{*name, *port, where};
}

/// Parse each element of the array `member`, in order; an absent member is an empty array.
template <typename Parse, typename Result>
void parseArray(const json& object, const char* member, Reader& reader, Parse parse, std::vector<Result>& results)
{
    const auto found = object.find(member);
    if (found == object.end())
        return;
    if (!found->is_array()) {
        reader.wrong({reader.file(), 0}, fmt::format("\"{}\" is not an array", member));
        return;
    }
    if (found->size() > MOST_PASSES) {
        reader.wrong({reader.file(), 0},
                     fmt::format("\"{}\" has {} elements; a graph has at most {}", member, found->size(), MOST_PASSES));
        return;
    }
    for (size_t i = 0; i < found->size(); ++i)
        if (auto result = parse((*found)[i], i, reader))
            results.push_back(std::move(*result));
}

}  // namespace

void Mistakes::add(const Location& where, const std::string& message, const std::string& help)
{
    if (++count_ > MOST_MISTAKES)
        return;
    if (!text_.empty())
        text_ += '\n';
    text_ += escaped(where.text() + ": " + message);
    if (!help.empty())
        text_ += "\n    " + escaped(help);
}

void Mistakes::raise() const
{
    if (count_ > MOST_MISTAKES)
        throw Error(fmt::format("{}\nand {} more mistakes", text_, count_ - MOST_MISTAKES));
    if (count_ > 0)
        throw Error(text_);
}

Description parseDescription(const json& object, const std::string& file, Mistakes& mistakes)
{
    Description description;
    description.location = {file, 0};
    if (!object.is_object()) {
        mistakes.add(description.location, "a graph is an object with \"name\", \"passes\" and \"outputs\"");
        return description;
    }
    description.location.file = Reader(mistakes, file).location(object).file;
    Reader reader(mistakes, description.location.file);
    if (const auto name = object.find("name"); name != object.end() && name->is_string())
        description.name = name->get<std::string>();
    else
        mistakes.add(description.location, "the graph needs a text \"name\"");
    parseArray(object, "passes", reader, parsePass, description.passes);
    parseArray(object, "outputs", reader, parseOutput, description.outputs);
    return description;
}

}  // namespace restirpg
