// restirpg view GRAPH ... --scene FILE: the live viewer, a program of the Python package, takes this process's place.
#include "app/commands.h"

#include "core/error.h"
#include "core/paths.h"

#include <cerrno>
#include <cstdlib>
#include <cstring>

#include <unistd.h>

namespace restirpg {
namespace {

[[noreturn]] void runViewer(const std::vector<std::string>& arguments)
{
    setenv("PYTHONPATH", pythonPath().c_str(), 1);
    auto command = pythonModule("restirpg.viewer");
    command.insert(command.end(), arguments.begin(), arguments.end());
    std::vector<char*> words;
    for (std::string& word : command)
        words.push_back(word.data());
    words.push_back(nullptr);
    execvp(words[0], words.data());
    fail("{}: cannot be started: {}; RESTIRPG_PYTHON names the interpreter", command.front(), std::strerror(errno));
}

}  // namespace

void addViewCommand(CLI::App& app)
{
    auto* command = app.add_subcommand("view", "Look at a scene through one graph or several, live in a browser");
    command->prefix_command();
    command->set_help_flag();
    command->callback([command] { runViewer(command->remaining()); });
}

}  // namespace restirpg
