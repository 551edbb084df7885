// Errors that a caller may want to tell apart from others: Python has classes of its own for them.
#pragma once

#include "core/error.h"

#include <filesystem>

namespace restirpg {

/// A file to read is not there: Python's FileNotFoundError too.
class MissingFile : public Error {
public:
    using Error::Error;
};

/// A value that a caller gave: Python's ValueError too.
class WrongValue : public Error {
public:
    using Error::Error;
};

/// A place that a caller gave, beyond the end of a list: Python's IndexError too.
class WrongIndex : public Error {
public:
    using Error::Error;
};

/// As fail, with an error of this kind.
template <typename Kind, typename... Args>
[[noreturn]] void failAs(fmt::format_string<Args...> format, Args&&... args)
{
    throw Kind(escaped(fmt::format(format, std::forward<Args>(args)...)));
}

/// As fail, for a file that could not be read: a MissingFile where there is none.
template <typename... Args>
[[noreturn]] void failToRead(const std::filesystem::path& file, fmt::format_string<Args...> format, Args&&... args)
{
    std::error_code ignored;
    if (!std::filesystem::exists(file, ignored))
        failAs<MissingFile>(format, std::forward<Args>(args)...);
    fail(format, std::forward<Args>(args)...);
}

}  // namespace restirpg
