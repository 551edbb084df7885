// Errors a user can mend, and the one way to raise them.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace restirpg {

/// A user's mistake or a failed precondition. `what()` is the whole message: the file, the place and the mend,
/// one line an error (several collected errors are joined by newlines). The program prints it and exits with code 2.
class Error : public std::runtime_error {
public:
    using std::runtime_error::runtime_error;
};

/// Raise an Error with a formatted message.
template <typename... Args>
[[noreturn]] void fail(fmt::format_string<Args...> format, Args&&... args)
{
    throw Error(fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace restirpg
