// The subcommands of the program, one file each. Each declares its options and runs when it was named.
#pragma once

#include <CLI/CLI.hpp>

namespace restirpg {

void addRenderCommand(CLI::App& app);
void addDescribeCommand(CLI::App& app);
void addGraphCommand(CLI::App& app);
void addDevicesCommand(CLI::App& app);
void addViewCommand(CLI::App& app);

}  // namespace restirpg
