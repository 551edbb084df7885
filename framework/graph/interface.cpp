#include "graph/interface.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>

namespace restirpg {
namespace {

bool isSnakeCase(const std::string& name)
{
    return !name.empty() && name[0] >= 'a' && name[0] <= 'z' && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_';
    });
}

template <typename Declarations>
bool contains(const Declarations& declarations, const std::string& name)
{
    return std::any_of(declarations.begin(), declarations.end(), [&](const auto& d) { return d.name == name; });
}

void checkName(const std::string& name, bool taken)
{
    if (!isSnakeCase(name))
        fail("it declares '{}'; names are lower_snake_case", name);
    if (taken)
        fail("it declares '{}' twice", name);
}

/// Inputs and knobs share one name space: both are keyword arguments of Graph.add.
void addKnob(std::vector<Knob>& knobs, const std::vector<InputPort>& inputs, Knob knob)
{
    checkName(knob.name, contains(inputs, knob.name) || contains(knobs, knob.name));
    knob.set(knob.get());  // the default obeys its own range
    knobs.push_back(std::move(knob));
}

void mark(std::vector<InputPort>& inputs, Moment moment)
{
    if (inputs.empty())
        fail("it tells an input's frame before any input is declared");
    inputs.back().moment = moment;
}

}  // namespace

void Interface::input(const std::string& name, In<Buffer>& target, PortType type, const std::string& meaning)
{
    checkName(name, contains(inputs_, name) || contains(knobs_, name));
    inputs_.push_back({name, std::move(type), meaning, false, &target});
}

void Interface::optionalInput(const std::string& name, In<Buffer>& target, PortType type, const std::string& meaning)
{
    input(name, target, std::move(type), meaning);
    inputs_.back().optional = true;
}

void Interface::ofThisFrame()
{
    mark(inputs_, Moment::thisFrame);
}

void Interface::ofFrameBefore()
{
    mark(inputs_, Moment::frameBefore);
}

void Interface::together(std::vector<std::string> names)
{
    for (const auto& name : names)
        if (!std::any_of(inputs_.begin(), inputs_.end(),
                         [&](const InputPort& input) { return input.optional && input.name == name; }))
            fail("'{}' is no optional input, or not yet: declare it before together()", name);
    groups_.push_back(std::move(names));
}

void Interface::output(const std::string& name, Out<Buffer>& target, PortType type, const std::string& meaning)
{
    checkName(name, contains(outputs_, name));
    outputs_.push_back({name, std::move(type), meaning, &target});
}

void Interface::knob(const std::string& name, bool& target, const std::string& meaning)
{
    addKnob(knobs_, inputs_, {name, &target, meaning, 0, 1, {}});
}

void Interface::knob(const std::string& name, int32_t& target, int32_t minimum, int32_t maximum,
                     const std::string& meaning)
{
    addKnob(knobs_, inputs_, {name, &target, meaning, double(minimum), double(maximum), {}});
}

void Interface::knob(const std::string& name, uint32_t& target, uint32_t minimum, uint32_t maximum,
                     const std::string& meaning)
{
    addKnob(knobs_, inputs_, {name, &target, meaning, double(minimum), double(maximum), {}});
}

void Interface::knob(const std::string& name, float& target, float minimum, float maximum, const std::string& meaning)
{
    addKnob(knobs_, inputs_, {name, &target, meaning, shortest(minimum), shortest(maximum), {}});
}

void Interface::knob(const std::string& name, std::string& target, const std::string& meaning)
{
    addKnob(knobs_, inputs_, {name, &target, meaning, 0, 0, {}});
}

void Interface::addChoice(const std::string& name, Knob::Selection selection, std::vector<std::string> choices,
                          const std::string& meaning)
{
    if (selection.get() >= choices.size())
        fail("the choice '{}' begins with a value that has no name", name);
    addKnob(knobs_, inputs_, {name, std::move(selection), meaning, 0, 0, std::move(choices)});
}

void Interface::structural()
{
    if (knobs_.empty())
        fail("it calls structural() before any knob is declared");
    knobs_.back().structural = true;
}

}  // namespace restirpg
