// Running another program and reading what it prints.
#pragma once

#include <chrono>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace restirpg {

/// Bytes that a program may print on either stream.
constexpr size_t MOST_PRINTED = 16u << 20;

struct ProcessResult {
    int exitCode = 0;  ///< 128 + signal number when a signal ended it
    bool timedOut = false;  ///< it was ended after `limit`
    bool tooMuch = false;  ///< it was ended for printing more than MOST_PRINTED
    std::string output;
    std::string errors;
};

/// Run `command` (program, arguments) without a shell and wait for it, no longer than `limit` and while it prints no
/// more than MOST_PRINTED: then it is ended by SIGKILL. `environment` is added to this process's own. Throws Error when
/// the program cannot be started.
ProcessResult runProcess(const std::vector<std::string>& command,
                         const std::map<std::string, std::string>& environment = {},
                         std::optional<std::chrono::milliseconds> limit = {});

}  // namespace restirpg
