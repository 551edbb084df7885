// The command line program. A user's mistake is one line on standard error and exit code 2.
#include "app/commands.h"

#include "core/error.h"

#include <fmt/format.h>

#include <algorithm>
#include <new>

namespace {

constexpr int EXIT_USER_ERROR = 2;

int refuse(const std::string& message)
{
    fmt::print(stderr, "{}\n", message);
    return EXIT_USER_ERROR;
}

/// CLI11's message, on one line and without the name of its exception class.
int refuseArguments(const CLI::ParseError& error)
{
    std::string message = error.what();
    std::replace(message.begin(), message.end(), '\n', ' ');
    return refuse(fmt::format("restirpg: {}; see restirpg --help", message));
}

}  // namespace

int main(int argc, char** argv)
{
    CLI::App app("Renders glTF scenes through render graphs, to compare light transport methods on equal terms", "restirpg");
    app.require_subcommand(1);
    restirpg::addRenderCommand(app);
    restirpg::addDescribeCommand(app);
    restirpg::addGraphCommand(app);
    restirpg::addDevicesCommand(app);
    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        return app.exit(help);
    } catch (const CLI::ParseError& error) {
        return refuseArguments(error);
    } catch (const restirpg::Error& error) {
        return refuse(error.what());
    } catch (const std::bad_alloc&) {
        return refuse("restirpg: out of memory; use a smaller image or scene");
    } catch (const std::exception& error) {
        fmt::print(stderr, "restirpg: internal error: {}\n", error.what());
        return 1;
    }
    return 0;
}
