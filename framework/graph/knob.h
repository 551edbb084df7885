// Typed knobs: what a user may turn on a pass, declared once.
#pragma once

#include <nlohmann/json.hpp>

#include <cstdint>
#include <functional>
#include <string>
#include <variant>
#include <vector>

namespace restirpg {

/// One knob of a pass, bound to the pass's member variable.
struct Knob {
    /// One of `choices`, by its place: an enumerator or constant of the pass.
    struct Selection {
        std::function<size_t()> get;
        std::function<void(size_t)> set;
    };
    using Target = std::variant<bool*, int32_t*, uint32_t*, float*, std::string*, Selection>;

    std::string name;
    Target target;
    std::string meaning;  ///< one sentence, with unit and source
    double minimum;  ///< inclusive; for numbers
    double maximum;
    std::vector<std::string> choices;  ///< of a Selection, by name
    bool structural = false;  ///< a change rebuilds the pass and empties all histories

    /// "bool", "int", "uint", "float", "choice" or "string".
    std::string typeName() const;
    nlohmann::json get() const;
    /// Throws WrongValue (without a place) when the type, the range or the choice is wrong.
    void check(const nlohmann::json& value) const;
    /// As check; the value is unchanged then.
    void set(const nlohmann::json& value);
    /// As set, from the text of `--set pass.knob=value`.
    void setFromText(const std::string& text);
};

/// JSON text in one line, also of texts that are no UTF-8.
std::string jsonText(const nlohmann::json& value);

/// The double that prints as the float does: 0.1f becomes 0.1, not 0.10000000149.
double shortest(float value);

}  // namespace restirpg
