// restirpg devices: the Vulkan devices of this machine.
#include "app/commands.h"

#include "core/error.h"
#include "core/table.h"
#include "gpu/device.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace restirpg {

void addDevicesCommand(CLI::App& app)
{
    auto* command =
        app.add_subcommand("devices", "List the Vulkan devices; --device takes the number or a part of the name");
    command->callback([] {
        const auto devices = listDevices();
        if (devices.empty())
            fail("no Vulkan device found; install a driver (for the CPU: mesa-vulkan-drivers >= 25)");
        Table table({"#", "name", "driver", "type", "back ends", "usable"});
        for (size_t i = 0; i < devices.size(); ++i) {
            const auto& device = devices[i];
            table.add({std::to_string(i), device.name, device.driver, device.type,
                       device.rayQuery ? "software, rayquery" : "software",
                       device.missing.empty() ? "yes" : fmt::format("no: lacks {}", fmt::join(device.missing, ", "))});
        }
        fmt::print("{}", table.text(""));
    });
}

}  // namespace restirpg
