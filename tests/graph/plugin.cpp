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

#ifndef TEST_PLUGIN_MEANING
#define TEST_PLUGIN_MEANING "Does nothing, well"
#endif
#ifndef TEST_PLUGIN_CREATE
#define TEST_PLUGIN_CREATE []() -> std::unique_ptr<restirpg::Pass> { return std::make_unique<restirpg::Plain>(); }
#endif
#ifndef TEST_PLUGIN_SOURCE
#define TEST_PLUGIN_SOURCE ""
#endif

#ifdef TEST_PLUGIN_NAME
extern "C" __attribute__((visibility("default")))
const restirpg::PluginEntry restirpgPlugin = {restirpg::PLUGIN_ABI + TEST_PLUGIN_ABI_OFFSET, TEST_PLUGIN_NAME,
                                              TEST_PLUGIN_MEANING, TEST_PLUGIN_CREATE, TEST_PLUGIN_SOURCE};
#endif
