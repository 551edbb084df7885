// A graph description, parsed from JSON into plain structs: its shape is right, its meaning unchecked.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace restirpg {

/// Where something was written in a graph file.
struct Location {
    std::string file;
    uint32_t line = 0;  ///< 0: unknown
    std::string text() const { return line ? file + ":" + std::to_string(line) : file; }
};

/// Collects a user's mistakes, to raise them together: who has three to mend wants to hear of three.
class Mistakes {
public:
    /// One mistake in one line; `help` goes indented below it.
    void add(const Location& where, const std::string& message, const std::string& help = {});
    bool empty() const { return count_ == 0; }
    /// Throws Error with every mistake so far, if there is one.
    void raise() const;

private:
    std::string text_;
    size_t count_ = 0;
};

/// The far end of an edge: "pass.output", this frame's or the frame before's.
struct DescribedPort {
    std::string pass;
    std::string output;
    bool delayed = false;
    std::string text() const { return delayed ? "prev(\"" + pass + "." + output + "\")" : pass + "." + output; }
};

struct DescribedPass {
    std::string name;
    std::string type;
    Location location;
    std::vector<std::pair<std::string, std::optional<DescribedPort>>> inputs;  ///< nullopt: unwired on purpose
    std::vector<std::pair<std::string, nlohmann::json>> knobs;
};

struct DescribedOutput {
    std::string name;
    DescribedPort port;
    Location location;
};

/// The schema stands in scripts/restirpg/graph.py.
struct Description {
    std::string name;
    Location location;  ///< of the file as a whole
    std::vector<DescribedPass> passes;
    std::vector<DescribedOutput> outputs;
};

/// Parse `json`. What has the wrong shape is reported and left out. `file` is the place where the description has none.
Description parseDescription(const nlohmann::json& json, const std::string& file, Mistakes& mistakes);

}  // namespace restirpg
