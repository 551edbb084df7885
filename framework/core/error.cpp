#include "core/error.h"

#include <cstdint>
#include <optional>

namespace restirpg {
namespace {

struct Character {
    uint32_t code;
    size_t bytes;
};

/// The character that `text`, not empty, begins with; nullopt when its first byte begins none (RFC 3629: no overlong
/// forms, no surrogates, nothing beyond U+10FFFF).
std::optional<Character> decode(std::string_view text)
{
    const auto byte = [&](size_t i) { return uint32_t(uint8_t(text[i])); };
    const uint32_t first = byte(0);
    if (first < 0x80)
        return Character{first, 1};
    const size_t count = first >= 0xf0 ? 4 : first >= 0xe0 ? 3 : 2;
    if (first < 0xc2 || first > 0xf4 || text.size() < count)
        return std::nullopt;
    uint32_t code = first & (0x7fu >> count);
    for (size_t i = 1; i < count; ++i) {
        if ((byte(i) & 0xc0) != 0x80)
            return std::nullopt;
        code = code << 6 | (byte(i) & 0x3f);
    }
    constexpr uint32_t LEAST[] = {0, 0, 0x80, 0x800, 0x10000};
    if (code < LEAST[count] || code > 0x10ffff || (code >= 0xd800 && code <= 0xdfff))
        return std::nullopt;
    return Character{code, count};
}

/// Control characters, line and paragraph separators, and the marks of bidirectional text.
bool isUnseen(uint32_t code)
{
    return code < 0x20 || (code >= 0x7f && code < 0xa0) || code == 0x200e || code == 0x200f ||
           (code >= 0x2028 && code <= 0x202e) || (code >= 0x2066 && code <= 0x2069);
}

std::string escapeOf(uint32_t code)
{
    switch (code) {
    case '\n':
        return "\\n";
    case '\r':
        return "\\r";
    case '\t':
        return "\\t";
    default:
        return code < 0x100 ? fmt::format("\\x{:02x}", code) : fmt::format("\\u{:04x}", code);
    }
}

}  // namespace

std::string escaped(std::string_view text, Breaks breaks)
{
    std::string result;
    result.reserve(text.size());
    while (!text.empty()) {
        const auto character = decode(text);
        const size_t bytes = character ? character->bytes : 1;
        const bool kept =
            character && (!isUnseen(character->code) || (character->code == '\n' && breaks == Breaks::kept));
        result += kept ? std::string(text.substr(0, bytes)) : escapeOf(character ? character->code : uint8_t(text[0]));
        text.remove_prefix(bytes);
    }
    return result;
}

std::string printable(std::string_view text, size_t longest)
{
    if (text.size() <= longest)
        return escaped(text);
    const auto continues = [&](size_t i) { return (uint8_t(text[i]) & 0xc0) == 0x80; };
    size_t end = longest;
    while (end > 0 && longest - end < 3 && continues(end))
        --end;
    return escaped(text.substr(0, end)) + "...";
}

}  // namespace restirpg
