// Warnings: each text once, of each kind the first few, the rest as a number.
#include "core/log.h"

#include <gtest/gtest.h>

#include <algorithm>

#include <fcntl.h>
#include <unistd.h>

namespace restirpg {
namespace {

size_t saidWith(const std::string& part)
{
    const auto said = saidWarnings();
    return size_t(
        std::count_if(said.begin(), said.end(), [&](const auto& text) { return text.find(part) != text.npos; }));
}

TEST(Log, OneTextIsSaidOnce)
{
    for (int i = 0; i < 3; ++i)
        warn("{}: twice", "once.gltf");
    EXPECT_EQ(saidWith("once.gltf"), 1u);
}

TEST(Log, ManyWarningsOfOneKindBecomeANumber)
{
    for (int round = 0; round < 2; ++round)
        for (int i = 0; i < 60000; ++i)
            warn("{}: node {} is odd", "many.gltf", i);
    EXPECT_EQ(saidWith("many.gltf"), WARNINGS_SAID);
    const auto omitted = omittedWarnings();
    EXPECT_EQ(std::count(omitted.begin(), omitted.end(), "59990 more like: many.gltf: node 0 is odd"), 1);
    warn("{}: node {} is odd", "other.gltf", 1);
    warn("{}: node {} is even", "many.gltf", 1);
    EXPECT_EQ(saidWith("other.gltf"), 1u);
    EXPECT_EQ(saidWith("is even"), 1u);
}

TEST(Log, AWarningIsOneLine)
{
    warn("{}: line\nbreak", "break.gltf");
    EXPECT_EQ(saidWith("break.gltf: line\\nbreak"), 1u);
}

TEST(Log, WhatStandardErrorCannotTakeIsLost)
{
    const int kept = dup(STDERR_FILENO), full = open("/dev/full", O_WRONLY);
    dup2(full, STDERR_FILENO);
    EXPECT_NO_THROW(warn("{}: on a full disk", "full.gltf"));
    EXPECT_NO_THROW(logInfo("on a full disk"));
    dup2(kept, STDERR_FILENO);
    close(kept);
    close(full);
    EXPECT_EQ(saidWith("full.gltf"), 1u);
}

}  // namespace
}  // namespace restirpg
