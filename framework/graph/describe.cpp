#include "graph/describe.h"

#include "core/error.h"
#include "core/table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

namespace restirpg {
namespace {

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

Table inputTable(const Interface& interface)
{
    Table table({"input", "type", "meaning"});
    for (const auto& input : interface.inputs())
        table.add({input.name + optionality(interface, input), input.type.name, input.meaning});
    return table;
}

Table outputTable(const Interface& interface)
{
    Table table({"output", "type", "size", "meaning"});
    for (const auto& output : interface.outputs())
        table.add({output.name, output.type.name, output.type.sizeText(), output.meaning});
    return table;
}

Table knobTable(const Interface& interface)
{
    Table table({"knob", "type", "default", "range", "meaning"});
    for (const auto& knob : interface.knobs())
        table.add({knob.name, knob.typeName(), valueOf(knob), rangeOf(knob),
                   knob.meaning + (knob.structural ? " (a change rebuilds the pass)" : "")});
    return table;
}

}  // namespace

std::string describePass(const PluginEntry& entry, TextFormat format)
{
    const auto [pass, interface] = runPlugin(fmt::format("pass type '{}' ", entry.name), [&] { return instantiate(entry); });
    const bool markdown = format == TextFormat::markdown;
    std::string text = markdown ? "" : fmt::format("{}: {}\n", entry.name, entry.meaning);
    for (const auto& table : {inputTable(interface), outputTable(interface), knobTable(interface)})
        if (!table.empty())
            text += (markdown && text.empty() ? "" : "\n") + (markdown ? table.markdown() : table.text());
    return text;
}

}  // namespace restirpg
