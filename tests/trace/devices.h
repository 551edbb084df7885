// The devices of the tracing tests.
#pragma once

#include "gpu/gpu_test.h"

namespace restirpg::test {

/// One device a back end; validation on.
inline Device& deviceOf(const std::string& backend)
{
    const DeviceOptions options{.device = testDevice(), .backend = backend, .validation = true};
    // A static object each, made after its driver and layer were loaded: it is then destroyed before theirs.
    if (backend == "software") {
        static Device software(options);
        return software;
    }
    static Device rayQuery(options);
    return rayQuery;
}

}  // namespace restirpg::test
