// Which pixels a pixel merges with in a round of spatial reuse. Compiled with RECIPROCAL = 1, pixels are paired; else each draws its own.
#ifndef RESTIRPG_RESTIR_REUSE_PARTICIPANTS_GLSL
#define RESTIRPG_RESTIR_REUSE_PARTICIPANTS_GLSL

#include "push.glsl"
#include "merge.glsl"
#include "pairs.glsl"
#include "math/short_list.glsl"

#ifndef RECIPROCAL
#define RECIPROCAL 0
#endif

/// Neighbour i of the pixel, if there is one whose surface is similar.
bool find_participant(uvec2 at, Appearance centre, uint i, out uint pixel)
{
#if RECIPROCAL
    uint self = pixel_index(at);
    pixel = chosen_partner(self, i);
    return pixel != INVALID_INDEX && chosen_partner(pixel, i) == self;
#else
    RandomKey key = reuse_key(at);
    vec2 u = random2(key, spatial_round(params.round), 2u * i);
    return find_neighbour(params.surface, at, centre, params.rules, i, u, key, pool_round(FIRST_OF_POOLS, params.round), pixel);
#endif
}

/// The pixels that a pixel merges with, INVALID_INDEX in place of one that was not found.
struct Neighbours {
    ShortList pixels;
    float confidence;  ///< of all together
    bool any;
};

Neighbours find_neighbours(uvec2 at)
{
    Appearance centre = load_appearance(params.surface, pixel_index(at));
    Neighbours found = Neighbours(ShortList(uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u)), 0.0, false);
    for (uint i = 0u; i < params.rules.neighbours; ++i) {
        uint pixel;
        if (find_participant(at, centre, i, pixel)) {
            found.confidence += PathReservoirArray(params.source).at[pixel].confidence;
            found.any = true;
        } else {
            pixel = INVALID_INDEX;
        }
        list_set(found.pixels, i, pixel);
    }
    return found;
}

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PathImageArray { PathImage at[]; };

/// The image of a partner's path y here.
PathReservoir with_image(PathReservoir y, PathImage image)
{
    y.f = image.f;
    y.geometry = image.geometry;
    y.anchor = image.anchor;
    y.place = image.place;
    return y;
}

#endif
