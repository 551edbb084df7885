// What a pass declares, as tables for the command line and for the passes' READMEs.
#pragma once

#include "graph/plugins.h"

#include <string>

namespace restirpg {

enum class TextFormat { plain, markdown };

/// The pass's inputs, outputs and knobs. Throws Error when the pass describes itself wrongly.
std::string describePass(const PluginEntry& entry, TextFormat format);

}  // namespace restirpg
