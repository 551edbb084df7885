// Parameters of random.comp, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_RANDOM_CASE_H
#define RESTIRPG_TEST_RANDOM_CASE_H
#ifdef __cplusplus
#include "shaders/types.h"
#else
#include "types.h"
#endif
RESTIRPG_SHARED

#ifdef __cplusplus
#define TEST_CONST constexpr uint
#else
#define TEST_CONST const uint
#endif

TEST_CONST GRID = 32u;  ///< cells a side of the pair histograms
TEST_CONST PAIRS = 4u;  ///< xy and zw of one address; x and y each with that of the next address

// Which part of the address runs.
TEST_CONST WALK_PIXEL_X = 0u;
TEST_CONST WALK_PIXEL_Y = 1u;
TEST_CONST WALK_FRAME = 2u;
TEST_CONST WALK_SEED = 3u;
TEST_CONST WALK_BOUNCE = 4u;
TEST_CONST WALK_DIMENSION = 5u;
TEST_CONST WALK_TREE = 6u;  ///< the first tree of a pixel and one of the others, in turn
TEST_CONST WALKS = 7u;

struct RandomCase {
    Address results;  ///< RandomCounts
    uint walk;  ///< WALK_*
    uint seed;
    uint weak;  ///< 1: without the hash's second half, an error made on purpose
};

struct RandomCounts {
    uint cells[PAIRS * GRID * GRID];
    uint outside;  ///< numbers that are not in [0, 1)
};

TEST_CONST REUSE_NUMBERS = 33u;  ///< that a round of reuse may take

struct ReuseNumbersCase {
    Address results;  ///< vec2 a number
    uint rounds;  ///< spatial ones
    uint overlapping;  ///< 1: each round has the addresses of one bounce alone, an error made on purpose
};

RESTIRPG_SHARED_END
#endif
