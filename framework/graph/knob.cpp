#include "graph/knob.h"

#include "core/error_kinds.h"
#include "core/nearest.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace restirpg {
namespace {

template <typename... Cases>
struct Overloaded : Cases... {
    using Cases::operator()...;
};
template <typename... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;

/// What a knob accepts, as a noun phrase.
std::string accepted(const Knob& knob)
{
    const std::string type = knob.typeName();
    if (type == "bool")
        return "true or false";
    if (type == "choice")
        return fmt::format("one of {}", fmt::join(knob.choices, ", "));
    if (type == "string")
        return "text";
    return fmt::format("a {} from {} to {}", type == "float" ? "number" : "whole number", knob.minimum, knob.maximum);
}

[[noreturn]] void refuse(const Knob& knob, const nlohmann::json& value)
{
    const std::string guess = value.is_string() ? didYouMean(value.get<std::string>(), knob.choices) : "";
    const std::string given = value.is_structured() ? std::string("an ") + value.type_name() : jsonText(value);
    failAs<WrongValue>("knob '{}' must be {}, not {}{}{}", knob.name, accepted(knob), given, guess.empty() ? "" : "; ",
                       guess);
}

/// Is it a number within the knob's range?
bool isInRange(const Knob& knob, const nlohmann::json& value, bool whole)
{
    if (whole ? !value.is_number_integer() : !value.is_number())
        return false;
    const double number = value.get<double>();
    return number >= knob.minimum && number <= knob.maximum;
}

/// All of `text` as a number, or text again when it is none: Knob::set then says what is wrong with it.
template <typename Number>
nlohmann::json numberFrom(const std::string& text)
{
    Number number{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(double(number)))
        return text;
    return number;
}

nlohmann::json booleanFrom(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const char* yes : {"true", "1", "on", "yes"})
        if (text == yes)
            return true;
    for (const char* no : {"false", "0", "off", "no"})
        if (text == no)
            return false;
    return text;
}

}  // namespace

std::string jsonText(const nlohmann::json& value)
{
    return value.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

double shortest(float value)
{
    const std::string text = fmt::format("{}", value);
    double result = 0;
    std::from_chars(text.data(), text.data() + text.size(), result);  // in any locale, unlike std::stod
    return result;
}

std::string Knob::typeName() const
{
    return std::visit(
        Overloaded{[](bool*) -> std::string { return "bool"; }, [](int32_t*) -> std::string { return "int"; },
                   [](uint32_t*) -> std::string { return "uint"; }, [](float*) -> std::string { return "float"; },
                   [](std::string*) -> std::string { return "string"; },
                   [](const Selection&) -> std::string { return "choice"; }},
        target);
}

nlohmann::json Knob::get() const
{
    return std::visit(
        Overloaded{[](float* value) -> nlohmann::json { return shortest(*value); },
                   [&](const Selection& selection) -> nlohmann::json { return choices.at(selection.get()); },
                   [](auto* value) -> nlohmann::json { return *value; }},
        target);
}

void Knob::check(const nlohmann::json& value) const
{
    const bool suits = std::visit(
        Overloaded{[&](bool*) { return value.is_boolean(); }, [&](float*) { return isInRange(*this, value, false); },
                   [&](std::string*) { return value.is_string(); },
                   [&](const Selection&) { return std::find(choices.begin(), choices.end(), value) != choices.end(); },
                   [&](auto*) { return isInRange(*this, value, true); }},
        target);
    if (!suits)
        refuse(*this, value);
}

void Knob::set(const nlohmann::json& value)
{
    check(value);
    std::visit(Overloaded{[&](Selection& selection) {
                              const auto found = std::find(choices.begin(), choices.end(), value);
                              selection.set(size_t(found - choices.begin()));
                          },
                          [&](auto* variable) { value.get_to(*variable); }},
               target);
}

void Knob::setFromText(const std::string& text)
{
    set(std::visit(
        Overloaded{[&](bool*) { return booleanFrom(text); }, [&](int32_t*) { return numberFrom<int64_t>(text); },
                   [&](uint32_t*) { return numberFrom<int64_t>(text); },
                   [&](float*) { return numberFrom<double>(text); }, [&](std::string*) { return nlohmann::json(text); },
                   [&](const Selection&) { return nlohmann::json(text); }},
        target));
}

}  // namespace restirpg
