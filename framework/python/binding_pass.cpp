// What passes declare: their ports and knobs.
#include "binding.h"

#include "graph/plugins.h"

#include <fmt/format.h>

namespace restirpg::python {
namespace {

constexpr const char* DESCRIBE_PASS =
    R"(What a pass type declares, as a dictionary of meaning, inputs, outputs and knobs.

inputs, outputs: a list of {name, type, channels, meaning}; channels: of a float image, 0 for another resource.
knobs: a list of {name, type, default, minimum, maximum, choices, structural, meaning}; type: "bool", "int", "uint", "float",
"choice" or "string"; minimum, maximum: of numbers, an int where the knob is one; structural: a change rebuilds the
pass. Raises Error for a type that is not there or does not load.)";

template <typename Port>
nlohmann::json describePorts(const std::vector<Port>& ports)
{
    auto list = nlohmann::json::array();
    for (const Port& port : ports)
        list.push_back({{"name", port.name},
                        {"type", port.type.name},
                        {"channels", port.type.channels},
                        {"meaning", port.meaning}});
    return list;
}

nlohmann::json describeKnob(const Knob& knob)
{
    const std::string type = knob.typeName();
    nlohmann::json entry = {{"name", knob.name},       {"type", type},
                            {"default", knob.get()},   {"choices", knob.choices},
                            {"meaning", knob.meaning}, {"structural", knob.structural}};
    if (type == "float") {
        entry["minimum"] = knob.minimum;
        entry["maximum"] = knob.maximum;
    }
    if (type == "int" || type == "uint") {  // the knob takes nothing else
        entry["minimum"] = int64_t(knob.minimum);
        entry["maximum"] = int64_t(knob.maximum);
    }
    return entry;
}

nlohmann::json describePass(const std::string& type)
{
    const Plugins plugins;
    const PluginEntry& entry = *plugins.get(type).entry;
    const auto [pass, interface] = runPlugin(fmt::format("pass type '{}' ", type), [&] { return instantiate(entry); });
    auto knobs = nlohmann::json::array();
    for (const Knob& knob : interface.knobs())
        knobs.push_back(describeKnob(knob));
    return {{"meaning", entry.meaning},
            {"inputs", describePorts(interface.inputs())},
            {"outputs", describePorts(interface.outputs())},
            {"knobs", knobs}};
}

}  // namespace

void bindPass(py::module_& module)
{
    module.def(
        "describe_pass", [](const std::string& type) { return toPython(describePass(type)); }, DESCRIBE_PASS,
        py::arg("type"));
}

}  // namespace restirpg::python
