// A few words to write graph descriptions with, as a graph file "g.py" would: one pass a line, from line 1.
#pragma once

#include "core/error.h"
#include "fake_passes.h"

#include <initializer_list>

namespace restirpg::test {

using nlohmann::json;

/// "gbuffer.surface", or "~fit.guide" for the frame before's.
inline json port(std::string text)
{
    json source = json::object();
    if (text.front() == '~') {
        source["delayed"] = true;
        text.erase(0, 1);
    }
    const auto dot = text.find('.');
    source["pass"] = text.substr(0, dot);
    source["output"] = text.substr(dot + 1);
    return source;
}

struct Writer {
    json graph{{"name", "Test"}, {"file", "g.py"}, {"passes", json::array()}, {"outputs", json::array()}};
    uint32_t line = 0;

    Writer& add(const std::string& name, const std::string& type,
                std::initializer_list<std::pair<const char*, const char*>> inputs = {}, json knobs = json::object())
    {
        json wired = json::object();
        for (const auto& [input, source] : inputs)
            wired[input] = source ? port(source) : json();
        graph["passes"].push_back({{"name", name},
                                   {"type", type},
                                   {"file", "g.py"},
                                   {"line", ++line},
                                   {"inputs", wired},
                                   {"knobs", std::move(knobs)}});
        return *this;
    }

    Writer& output(const std::string& name, const std::string& source)
    {
        json described = port(source);
        described.update({{"name", name}, {"file", "g.py"}, {"line", ++line}});
        graph["outputs"].push_back(described);
        return *this;
    }
};

/// What the graph says is wrong with a description; empty when nothing is.
inline std::string mistakes(const json& description)
{
    try {
        Graph graph(description, fakePlugins());
    } catch (const Error& error) {
        return error.what();
    }
    return {};
}

/// gbuffer, paths, accumulate; more can be added. Lines 1 to 4.
inline Writer pathTracer(json knobs = json::object())
{
    Writer writer;
    writer.add("gbuffer", "GBuffer")
        .add("paths", "Paths", {{"surface", "gbuffer.surface"}}, std::move(knobs))
        .add("accumulate", "Accumulate", {{"direct", "paths.radiance"}, {"history", "~accumulate.sums"}})
        .output("image", "accumulate.mean");
    return writer;
}

}  // namespace restirpg::test
