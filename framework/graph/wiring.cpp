#include "graph/wiring.h"

#include "core/error.h"
#include "core/nearest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <tuple>

namespace restirpg {
namespace {

template <typename Declarations>
std::optional<uint32_t> indexOf(const Declarations& declarations, const std::string& name)
{
    const auto found =
        std::find_if(declarations.begin(), declarations.end(), [&](const auto& d) { return d.name == name; });
    if (found == declarations.end())
        return std::nullopt;
    return uint32_t(found - declarations.begin());
}

/// "KIND: a, b        did you mean 'a'?"
std::string choicesHelp(const std::string& kind, const std::vector<std::string>& shown, const std::string& asked,
                        const std::vector<std::string>& names)
{
    const auto guess = didYouMean(asked, names);
    return fmt::format("{}: {}{}{}", kind, shown.empty() ? "none" : fmt::format("{}", fmt::join(shown, ", ")),
                       guess.empty() ? "" : "        ", guess);
}

std::vector<std::string> shownInputs(const Interface& interface)
{
    std::vector<std::string> shown;
    for (const auto& input : interface.inputs())
        shown.push_back(input.name + (input.optional ? " (optional)" : ""));
    return shown;
}

/// The work of wire(), step by step over one description.
class Wirer {
public:
    Wirer(const Description& description, const Plugins& plugins, Mistakes& mistakes)
        : description_(description), plugins_(plugins), mistakes_(mistakes)
    {
    }

    Wiring run()
    {
        for (const auto& described : description_.passes)
            createPass(described);
        for (uint32_t i = 0; i < description_.passes.size(); ++i) {
            if (!wiring_.passes[i].pass)
                continue;
            wireInputs(description_.passes[i], i);
            setKnobs(description_.passes[i], wiring_.passes[i]);
        }
        addOutputs();
        return std::move(wiring_);
    }

private:
    void createPass(const DescribedPass& described)
    {
        GraphPass created{described.name, described.type, described.location};
        if (const auto first = indexOf(wiring_.passes, described.name))
            mistakes_.add(described.location, fmt::format("pass '{}' is added twice, first at {}", described.name,
                                                          wiring_.passes[*first].location.text()));
        if (const auto* plugin = plugins_.find(described.type)) {
            try {
                created.entry = plugin->entry;
                std::tie(created.pass, created.interface) = instantiate(*plugin->entry);
            } catch (const Error& error) {
                mistakes_.add(described.location, fmt::format("{} {}", label(created), error.what()));
            }
        } else {
            reportMissing(described);
        }
        wiring_.passes.push_back(std::move(created));
    }

    void reportMissing(const DescribedPass& described)
    {
        const auto names = plugins_.names();
        if (const auto problem = plugins_.problem(described.type); !problem.empty()) {
            mistakes_.add(described.location,
                          fmt::format("pass type '{}' cannot be loaded: {}", described.type, problem));
        } else if (names.empty()) {
            mistakes_.add(
                described.location, fmt::format("there is no pass type '{}'", described.type),
                fmt::format("no passes found in {}; add folders in RESTIRPG_PLUGIN_PATH", plugins_.searched()));
        } else {
            mistakes_.add(described.location, fmt::format("there is no pass type '{}'", described.type),
                          choicesHelp("pass types", names, described.type, names));
        }
    }

    void wireInputs(const DescribedPass& described, uint32_t target)
    {
        const auto& pass = wiring_.passes[target];
        const auto& inputs = pass.interface.inputs();
        std::vector<bool> settled(inputs.size(), false);  // wired, or already complained about
        for (const auto& [name, source] : described.inputs) {
            const auto input = indexOf(inputs, name);
            if (!input) {
                reportNoInput(pass, name, source.has_value());
            } else if (source) {
                settled[*input] = true;
                wireInput(*source, target, *input);
            }
        }
        for (const auto& [name, value] : described.knobs)
            if (const auto input = indexOf(inputs, name))
                settled[*input] = true;  // setKnobs says so
        for (size_t i = 0; i < inputs.size(); ++i)
            if (!inputs[i].optional && !settled[i])
                mistakes_.add(pass.location, fmt::format("{} needs its input '{}' wired", label(pass), inputs[i].name),
                              typeHelp(inputs[i].type));
        for (const auto& group : pass.interface.groups())
            checkGroup(pass, group, settled);
    }

    /// Inputs that go together are all wired, or none.
    void checkGroup(const GraphPass& pass, const std::vector<std::string>& group, const std::vector<bool>& settled)
    {
        std::vector<std::string> wired, missing;
        for (const auto& name : group)
            (settled[*indexOf(pass.interface.inputs(), name)] ? wired : missing).push_back(name);
        if (!wired.empty() && !missing.empty())
            mistakes_.add(pass.location,
                          fmt::format("{} has '{}' wired, but not '{}'", label(pass), fmt::join(wired, "', '"),
                                      fmt::join(missing, "', '")),
                          fmt::format("wire all of {}, or none", fmt::join(group, ", ")));
    }

    void reportNoInput(const GraphPass& pass, const std::string& name, bool wired)
    {
        if (indexOf(pass.interface.knobs(), name))
            mistakes_.add(pass.location, fmt::format("'{}' of {} is a knob: give it a value, not {}", name, label(pass),
                                                     wired ? "an output of a pass" : "None"));
        else
            mistakes_.add(pass.location, fmt::format("{} has no input '{}'", label(pass), name),
                          choicesHelp("inputs", shownInputs(pass.interface), name, namesOf(pass.interface.inputs())));
    }

    void wireInput(const DescribedPort& port, uint32_t target, uint32_t input)
    {
        const auto& pass = wiring_.passes[target];
        const auto& wanted = pass.interface.inputs()[input];
        const auto source = resolve(port, pass.location, fmt::format("input '{}' of {}", wanted.name, label(pass)));
        if (!source)
            return;
        const auto& found = wiring_.passes[source->first].interface.outputs()[source->second];
        if (!wanted.type.takes(found.type))
            mistakes_.add(pass.location,
                          fmt::format("input '{}' of {} takes {}, but {} is {}", wanted.name, label(pass),
                                      wanted.type.name, port.text(), found.type.name),
                          typeHelp(wanted.type));
        else if (wanted.moment == (port.delayed ? Moment::thisFrame : Moment::frameBefore))
            mistakes_.add(pass.location,
                          fmt::format("input '{}' of {} takes what was made {}, but {} is of {}", wanted.name,
                                      label(pass), port.delayed ? "in this frame" : "one frame ago", port.text(),
                                      port.delayed ? "the frame before" : "this frame"),
                          fmt::format("wire it to {}", DescribedPort{port.pass, port.output, !port.delayed}.text()));
        else
            wiring_.edges.push_back({source->first, source->second, target, input, port.delayed});
    }

    /// The pass and output that `port` names; nullopt with a mistake, or without when the pass's type is unknown.
    std::optional<std::pair<uint32_t, uint32_t>> resolve(const DescribedPort& port, const Location& where,
                                                         const std::string& reader)
    {
        const auto source = indexOf(wiring_.passes, port.pass);
        if (!source) {
            const auto names = namesOf(wiring_.passes);
            mistakes_.add(where, fmt::format("{} reads {}, but there is no pass '{}'", reader, port.text(), port.pass),
                          choicesHelp("passes", names, port.pass, names));
            return std::nullopt;
        }
        const auto& pass = wiring_.passes[*source];
        if (!pass.pass)
            return std::nullopt;
        const auto output = indexOf(pass.interface.outputs(), port.output);
        if (!output) {
            const auto names = namesOf(pass.interface.outputs());
            mistakes_.add(
                where,
                fmt::format("{} reads {}, but {} has no output '{}'", reader, port.text(), label(pass), port.output),
                choicesHelp("outputs", names, port.output, names));
            return std::nullopt;
        }
        return std::pair(*source, *output);
    }

    /// Which outputs of the graph would fit.
    std::string typeHelp(const PortType& type) const
    {
        std::vector<std::string> fitting;
        for (const auto& pass : wiring_.passes)
            for (const auto& output : pass.interface.outputs())
                if (type.takes(output.type))
                    fitting.push_back(pathOf(pass, output.name));
        return fmt::format("outputs of type {}: {}", type.name,
                           fitting.empty() ? "none" : fmt::format("{}", fmt::join(fitting, ", ")));
    }

    void setKnobs(const DescribedPass& described, GraphPass& pass)
    {
        for (const auto& [name, value] : described.knobs) {
            if (indexOf(pass.interface.inputs(), name)) {
                mistakes_.add(pass.location,
                              fmt::format("'{}' of {} is an input: wire it to an output of a pass", name, label(pass)),
                              typeHelp(pass.interface.inputs()[*indexOf(pass.interface.inputs(), name)].type));
                continue;
            }
            auto* knob = findKnob(pass, name);
            if (!knob) {
                auto candidates = namesOf(pass.interface.knobs());
                mistakes_.add(pass.location, fmt::format("{} has no knob '{}'", label(pass), name),
                              choicesHelp("knobs", candidates, name, candidates));
                continue;
            }
            try {
                knob->set(value);
            } catch (const Error& error) {
                mistakes_.add(pass.location, fmt::format("{}: {}", label(pass), error.what()));
            }
        }
    }

    void addOutputs()
    {
        if (description_.outputs.empty())
            mistakes_.add(description_.location,
                          "the graph has no output; add one, as in g.output(\"image\", accumulate.mean)");
        for (const auto& described : description_.outputs) {
            if (indexOf(wiring_.outputs, described.name))
                mistakes_.add(described.location, fmt::format("output '{}' is added twice", described.name));
            else if (const auto source =
                         resolve(described.port, described.location, fmt::format("output '{}'", described.name)))
                wiring_.outputs.push_back({described.name, source->first, source->second});
        }
    }

    const Description& description_;
    const Plugins& plugins_;
    Mistakes& mistakes_;
    Wiring wiring_;
};

}  // namespace

Wiring wire(const Description& description, const Plugins& plugins, Mistakes& mistakes)
{
    return Wirer(description, plugins, mistakes).run();
}

std::string label(const GraphPass& pass)
{
    return fmt::format("pass '{}' ({})", pass.name, pass.type);
}

std::string placeOf(const GraphPass& pass)
{
    return pass.location.text() + ": " + label(pass);
}

Knob* findKnob(GraphPass& pass, const std::string& name)
{
    auto& knobs = pass.interface.knobs();
    const auto found = std::find_if(knobs.begin(), knobs.end(), [&](const Knob& knob) { return knob.name == name; });
    return found == knobs.end() ? nullptr : &*found;
}

}  // namespace restirpg
