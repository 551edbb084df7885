// Which pixels a pixel merges with. By G-buffer and random numbers alone: a choice that looked at the reservoirs would
// be biased.
#ifndef RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL
#define RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL

#include "merge.glsl"
#include "restir/neighbours.glsl"

/// Where the numbers of a round begin that choose from pools: MAX_POOL addresses a neighbour.
uint pool_round(uint round)
{
    return RANDOM_POOLS + round * (MAX_NEIGHBOURS * MAX_POOL / RANDOM_DIMENSIONS);
}

/// Add the pixel that showed this surface in the frame before, when there is one.
void add_previous(ReSTIRDIParameters params, RandomKey key, uvec2 at, Hit hit, vec2 motion)
{
    vec2 u = random2(key, RANDOM_PARTICIPANTS + TEMPORAL_ROUND, 0u);
    uint pixel;
    if (find_history(merge.surfaces, hit, at, motion, u, params.rules, pixel))
        add_neighbour(pixel, min(merge.reservoirs.at[pixel].confidence, params.cap));
}

/// Add up to rules.neighbours pixels of the disk about this one.
void add_around(ReSTIRDIParameters params, RandomKey key, uvec2 at)
{
    Appearance centre = load_appearance(merge.surfaces, at.y * frame.c.size.x + at.x);
    NeighbourRules rules = params.rules;
    for (uint i = 0u; i < rules.neighbours; ++i) {
        uint pixel;
        Appearance there;
        bool found = rules.pool > 1u
                         ? choose_compatible(merge.surfaces, at, centre, rules, key, pool_round(params.round), i * MAX_POOL, pixel)
                         : draw_neighbour(merge.surfaces, at, centre, rules, random2(key, RANDOM_PARTICIPANTS + params.round, i), pixel, there);
        if (found)
            add_neighbour(pixel, merge.reservoirs.at[pixel].confidence);
    }
}

#endif
