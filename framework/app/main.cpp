// The command line program. A user's mistake is one line on standard error and exit code 2.
#include "app/commands.h"

#include "core/error.h"
#include "core/log.h"
#include "core/nearest.h"
#include "graph/pass.h"
#include "render/version.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <new>
#include <sstream>
#include <system_error>

namespace {

constexpr int EXIT_USER_ERROR = 2;

int refuse(const std::string& message)
{
    restirpg::logInfo(message);
    return EXIT_USER_ERROR;
}

/// A first word that is no subcommand: CLI11 would only say that one is missing.
void checkSubcommand(const CLI::App& app, int argc, char** argv)
{
    std::vector<std::string> names;
    for (const auto* subcommand : app.get_subcommands({}))
        names.push_back(subcommand->get_name());
    if (argc < 2 || argv[1][0] == '-' || std::find(names.begin(), names.end(), argv[1]) != names.end())
        return;
    const auto guess = restirpg::didYouMean(argv[1], names);
    restirpg::fail("restirpg: there is no subcommand '{}'; subcommands: {}{}{}", argv[1], fmt::join(names, ", "),
                   guess.empty() ? "" : "; ", guess);
}

/// CLI11's message, on one line and without the name of its exception class.
int refuseArguments(const CLI::ParseError& error)
{
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    return refuse(fmt::format("restirpg: {}; see restirpg --help", message));
}

/// What was printed may still wait in a buffer, and a full disk is only seen when it leaves it.
void flushOutput()
{
    if (std::fflush(stdout) != 0 || std::ferror(stdout))
        restirpg::fail("standard output: cannot write: {}; free some space or write elsewhere", std::strerror(errno));
}

/// Help and version are printed here too: CLI11 would not notice that they cannot be.
void runCommand(CLI::App& app, int argc, char** argv)
{
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        std::ostringstream text;
        app.exit(help, text);
        fmt::print("{}", text.str());
    }
    flushOutput();
}

}  // namespace

int main(int argc, char** argv)
{
    // Beyond `ulimit -f` a write fails, also one to standard output; the signal would end the program without a word.
    std::signal(SIGXFSZ, SIG_IGN);
    CLI::App app("Renders glTF scenes through render graphs, to compare light transport methods on equal terms",
                 "restirpg");
    app.set_version_flag("--version", fmt::format("restirpg {}, commit {}, plugin ABI {}", restirpg::VERSION,
                                                  restirpg::COMMIT, restirpg::PLUGIN_ABI));
    app.require_subcommand(1);
    restirpg::addRenderCommand(app);
    restirpg::addDescribeCommand(app);
    restirpg::addGraphCommand(app);
    restirpg::addDevicesCommand(app);
    restirpg::addViewCommand(app);
    try {
        checkSubcommand(app, argc, argv);
        runCommand(app, argc, argv);
    } catch (const CLI::ParseError& error) {
        return refuseArguments(error);
    } catch (const restirpg::Error& error) {
        return refuse(error.what());
    } catch (const std::bad_alloc&) {
        return refuse("restirpg: out of memory; use a smaller image or scene");
    } catch (const std::system_error& error) {
        // fmt::print's, when standard output cannot be written.
        return refuse(fmt::format("restirpg: {}", error.what()));
    } catch (const std::exception& error) {
        restirpg::logInfo(fmt::format("restirpg: internal error: {}", restirpg::escaped(error.what())));
        return 1;
    }
    return 0;
}
