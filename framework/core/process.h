// Running another program and reading what it prints.
#pragma once

#include <map>
#include <string>
#include <vector>

namespace restirpg {

struct ProcessResult {
    int exitCode = 0;  ///< 128 + signal number when a signal ended it
    std::string output;
    std::string errors;
};

/// Run `command` (program, arguments) without a shell and wait for it. `environment` is added to this process's own.
/// Throws Error when the program cannot be started.
ProcessResult runProcess(const std::vector<std::string>& command,
                         const std::map<std::string, std::string>& environment = {});

}  // namespace restirpg
