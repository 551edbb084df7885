// restirpg describe [PASS] [--markdown]: ports and knobs of the passes at hand.
#include "app/commands.h"

#include "core/error.h"
#include "core/log.h"
#include "graph/describe.h"

#include <fmt/format.h>

namespace restirpg {
namespace {

struct DescribeOptions {
    std::string pass;
    bool markdown = false;
};

void describeAll(const Plugins& plugins, TextFormat format)
{
    if (plugins.names().empty())
        fail("no passes found in {}; add folders in RESTIRPG_PLUGIN_PATH", plugins.searched());
    bool first = true;
    for (const auto& name : plugins.names()) {
        const auto* plugin = plugins.find(name);
        if (!plugin) {
            warn("{}", plugins.problem(name));
            continue;
        }
        fmt::print("{}{}", first ? "" : "\n", format == TextFormat::markdown ? fmt::format("## {}\n\n", name) : "");
        fmt::print("{}", describePass(*plugin->entry, format));
        first = false;
    }
}

}  // namespace

void addDescribeCommand(CLI::App& app)
{
    auto* command = app.add_subcommand("describe", "Print the ports and knobs of a pass, or of all");
    auto options = std::make_shared<DescribeOptions>();
    command->add_option("PASS", options->pass, "Type of the pass; without it: all");
    command->add_flag("--markdown", options->markdown, "As the READMEs of the passes have it");
    command->callback([options] {
        const Plugins plugins;
        const auto format = options->markdown ? TextFormat::markdown : TextFormat::plain;
        if (options->pass.empty())
            describeAll(plugins, format);
        else
            fmt::print("{}", describePass(*plugins.get(options->pass).entry, format));
    });
}

}  // namespace restirpg
