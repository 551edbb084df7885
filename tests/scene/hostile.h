// What the tests of damaged files share.
#pragma once
#include "gltf_builder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <functional>
#include <string>
#include <vector>

namespace restirpg {

/// The Error of the square scene after `damage`; it must contain every one of `parts`.
inline void expectError(const std::function<void(GltfBuilder&)>& damage, const std::vector<std::string>& parts)
{
    auto builder = squareScene();
    damage(builder);
    const auto message = errorOf(builder);
    EXPECT_NE(message.find("scene.glb"), message.npos) << message;
    for (const auto& part : parts)
        EXPECT_NE(message.find(part), message.npos) << message << "\n  does not say: " << part;
}

inline nlohmann::json& primitiveOf(GltfBuilder& builder)
{
    return builder.json["meshes"][0]["primitives"][0];
}

/// In a process that may take little memory.
class HostileInLittleMemory : public testing::Test {
protected:
    void SetUp() override
    {
#if defined(__SANITIZE_ADDRESS__)
        GTEST_SKIP() << "the sanitizer takes terabytes of address space";
#endif
        getrlimit(RLIMIT_AS, &before_);
    }

    void TearDown() override
    {
        setrlimit(RLIMIT_AS, &before_);
    }

    void limitTo(rlim_t gibibytes) const
    {
        const rlimit limited = {gibibytes << 30, before_.rlim_max};
        setrlimit(RLIMIT_AS, &limited);
    }

private:
    rlimit before_{RLIM_INFINITY, RLIM_INFINITY};
};

}  // namespace restirpg
