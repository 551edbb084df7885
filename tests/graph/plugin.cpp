// One source for the plugin libraries of files_test.cpp: a good one, and those that went wrong.
#include "graph/pass.h"

namespace restirpg {

class Plain final : public Pass {
public:
    void describe(Interface&) override {}
    void build(Device&) override {}
    void record(Frame&) override {}
};

}  // namespace restirpg

#ifdef TEST_PLUGIN_NAME
extern "C" __attribute__((visibility("default"))) const restirpg::PluginEntry restirpgPlugin = {
    restirpg::PLUGIN_ABI + TEST_PLUGIN_ABI_OFFSET, TEST_PLUGIN_NAME, "Does nothing, well",
    []() -> std::unique_ptr<restirpg::Pass> { return std::make_unique<restirpg::Plain>(); }};
#endif
