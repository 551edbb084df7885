#include "graph/describe.h"

#include "core/error.h"
#include "core/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

namespace restirpg {
namespace {

constexpr size_t TEXT_WIDTH = 100;  ///< columns of a terminal

/// What a knob accepts, short: "0 .. 64", "world, screen".
std::string rangeOf(const Knob& knob)
{
    const std::string type = knob.typeName();
    if (type == "choice")
        return fmt::format("{}", fmt::join(knob.choices, ", "));
    if (type == "bool" || type == "string")
        return "";
    return fmt::format("{} .. {}", knob.minimum, knob.maximum);
}

std::string valueOf(const Knob& knob)
{
    const auto value = knob.get();
    return value.is_string() ? value.get<std::string>() : value.dump();
}

/// " (optional)", " (optional, with history)" or nothing.
std::string optionality(const Interface& interface, const InputPort& input)
{
    if (!input.optional)
        return {};
    std::vector<std::string> others;
    const auto isOther = [&](const std::string& name) { return name != input.name; };
    for (const auto& group : interface.groups())
        if (std::find(group.begin(), group.end(), input.name) != group.end())
            std::copy_if(group.begin(), group.end(), std::back_inserter(others), isOther);
    return others.empty() ? " (optional)" : fmt::format(" (optional, with {})", fmt::join(others, " and "));
}

/// In plain text, where columns are narrow, what an optional input goes with stands in its meaning.
Table inputTable(const Interface& interface, TextFormat format)
{
    Table table({"input", "type", "meaning"});
    for (const auto& input : interface.inputs())
        if (format == TextFormat::markdown)
            table.add({input.name + optionality(interface, input), input.type.name, input.meaning});
        else
            table.add({input.name, input.type.name, input.meaning + optionality(interface, input)});
    return table;
}

Table outputTable(const Interface& interface)
{
    Table table({"output", "type", "size", "meaning"});
    for (const auto& output : interface.outputs())
        table.add({output.name, output.type.name, output.type.sizeText(), output.meaning});
    return table;
}

/// Long ranges, choices of many, stand with the meaning in plain text, where columns are narrow.
Table knobTable(const Interface& interface, TextFormat format)
{
    constexpr size_t LONG = 24;
    Table table({"knob", "type", "default", "range", "meaning"});
    for (const auto& knob : interface.knobs()) {
        const std::string range = rangeOf(knob);
        const bool beside = format == TextFormat::markdown || range.size() <= LONG;
        table.add({knob.name, knob.typeName(), valueOf(knob), beside ? range : "",
                   (beside ? "" : "one of " + range + ": ") + knob.meaning +
                       (knob.structural ? " (a change rebuilds the pass)" : "")});
    }
    return table;
}

}  // namespace

std::string describePass(const PluginEntry& entry, TextFormat format)
{
    const auto [pass, interface] =
        runPlugin(fmt::format("pass type '{}' ", entry.name), [&] { return instantiate(entry); });
    const bool markdown = format == TextFormat::markdown;
    std::string text = markdown ? "" : wrapped(fmt::format("{}: {}", entry.name, entry.meaning), 2, TEXT_WIDTH) + "\n";
    for (const auto& table : {inputTable(interface, format), outputTable(interface), knobTable(interface, format)})
        if (!table.empty())
            text +=
                (markdown && text.empty() ? "" : "\n") + (markdown ? table.markdown() : table.text("  ", TEXT_WIDTH));
    return text;
}

}  // namespace restirpg
