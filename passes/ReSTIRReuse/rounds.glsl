// Where the random numbers of each round of reuse begin: its "bounce" (random.glsl). No two rounds share a number, for whom a pixel merges
// with must not depend on what the merges before have left there.
#ifndef RESTIRPG_RESTIR_REUSE_ROUNDS_GLSL
#define RESTIRPG_RESTIR_REUSE_ROUNDS_GLSL

#include "restir/neighbours.glsl"

/// Numbers of a spatial round: two a neighbour, and one for the centre.
const uint SPATIAL_NUMBERS = 2u * MAX_NEIGHBOURS + 1u;

uint spatial_round(uint round)
{
    return round * ((SPATIAL_NUMBERS + RANDOM_DIMENSIONS - 1u) / RANDOM_DIMENSIONS);
}

/// Where the numbers begin that choose from pools, and those that pair pixels: see pool_round.
const uint FIRST_OF_POOLS = 0x20000u;
const uint FIRST_OF_PARTNERS = 0x30000u;

#endif
