// Errors a user can mend, and the one way to raise them.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>
#include <string_view>

namespace restirpg {

/// What line breaks in a text become.
enum class Breaks { kept, escaped };

/// `text` as any terminal and any reader of UTF-8 may have it. A name in a file may hold anything: control characters,
/// which steer terminals, marks that turn the direction of writing, and bytes that are no UTF-8 become \n, \x1b,
/// \u202e, \xff.
std::string escaped(std::string_view text, Breaks breaks = Breaks::escaped);

/// What a message says of a text from a file: escaped, and no more than the first `longest` bytes in whole
/// characters.
std::string printable(std::string_view text, size_t longest = 200);

/// A user's mistake or a failed precondition. `what()` is the whole message: the file, the place and the mend,
/// one line an error (several collected errors are joined by newlines). The program prints it and exits with code 2.
class Error : public std::runtime_error {
public:
    explicit Error(std::string_view text) : std::runtime_error(escaped(text, Breaks::kept)) {}
};

/// Raise an Error with a formatted message of one line.
template <typename... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args)
{
    throw Error(escaped(fmt::format(format, std::forward<Args>(args)...)));
}

}  // namespace restirpg
