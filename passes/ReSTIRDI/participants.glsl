// Which pixels a pixel merges with. By G-buffer and random numbers alone: a choice that looked at the reservoirs would
// be biased.
#ifndef RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL
#define RESTIRPG_RESTIR_DI_PARTICIPANTS_GLSL

#include "push.glsl"
#include "merge.glsl"
#include "restir/neighbours.glsl"

/// Add the pixel that showed this surface in the frame before, when there is one.
void add_previous(RandomKey key, uvec2 at, Hit hit, vec2 motion)
{
    vec2 u = random2(key, RANDOM_PARTICIPANTS + TEMPORAL_ROUND, 0u);
    uint pixel;
    if (find_history(merge.surfaces, hit, at, motion, u, params.rules, pixel))
        add_neighbour(pixel, min(merge.reservoirs.at[pixel].confidence, params.cap));
}

/// Add up to rules.neighbours pixels of the disk about this one.
void add_around(RandomKey key, uvec2 at)
{
    Appearance centre = load_appearance(merge.surfaces, pixel_index(at));
    uint pools = pool_round(RANDOM_POOLS, params.round);
    for (uint i = 0u; i < params.rules.neighbours; ++i) {
        vec2 u = random2(key, RANDOM_PARTICIPANTS + params.round, i);
        uint pixel;
        if (find_neighbour(merge.surfaces, at, centre, params.rules, i, u, key, pools, pixel))
            add_neighbour(pixel, merge.reservoirs.at[pixel].confidence);
    }
}

#endif
