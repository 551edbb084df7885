// Pairs of pixels, so that one shift serves both [shaders/README: Reciprocal pairs].
#ifndef RESTIRPG_RESTIR_REUSE_PAIRS_GLSL
#define RESTIRPG_RESTIR_REUSE_PAIRS_GLSL

#include "push.glsl"
#include "merge.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 4) buffer PartnerArray { uint at[]; };

/// The pixel that pattern number `pattern` pairs with this one: it pairs that pixel with this one. false: it would be outside of the
/// image, or this pixel itself.
bool find_partner(uvec2 at, uint side, uint pattern, out uvec2 partner)
{
    const uint NO_PIXEL = 0xffffffffu;
    RandomKey key = RandomKey(NO_PIXEL, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE);
    uint numbers = pool_round(FIRST_OF_PARTNERS, params.round);
    uvec2 shift = uvec2(random2(key, numbers, pattern) * float(side));
    uvec2 tile = (at + shift) / side;
    uvec2 place = (at + shift) % side;
    uvec2 turn = uvec2(random2(random_key(tile, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE), numbers, pattern) * float(side));
    ivec2 found = ivec2(tile * side + (turn + side - place) % side) - ivec2(shift);
    partner = uvec2(found);
    return all(greaterThanEqual(found, ivec2(0))) && all(lessThan(found, ivec2(frame.c.size))) && partner != at;
}

/// A pixel as pairs see it.
struct Seen {
    uvec2 at;
    Appearance looks;
    vec3 position;
};

Seen see(uvec2 at)
{
    Appearance looks = load_appearance(params.surface, pixel_index(at));
    return Seen(at, looks, seen_position(at, looks));
}

/// What a pattern's pair bids for being chosen, 0 if the surfaces are not similar: the largest bid of a pool is that of each member with
/// a chance in proportion to its compatibility. Both pixels find the same number: nothing depends on which of them asks.
float pair_bid(Seen a, Seen b, uint pattern)
{
    bool a_is_nearer = a.looks.distance <= b.looks.distance;
    Appearance nearer = Appearance(a_is_nearer ? a.looks.normal : b.looks.normal, min(a.looks.distance, b.looks.distance));
    Appearance other = Appearance(a_is_nearer ? b.looks.normal : a.looks.normal, max(a.looks.distance, b.looks.distance));
    if (!is_similar(nearer, other, params.rules.normalThreshold, params.rules.depthThreshold))  // and so the other way round
        return 0.0;
    // The race of exponential variates: -log(u) / score is least for a member with a chance in proportion to its score.
    bool a_is_first = a.at.y < b.at.y || (a.at.y == b.at.y && a.at.x < b.at.x);
    float u = random1(reuse_key(a_is_first ? a.at : b.at), pool_round(FIRST_OF_POOLS, params.round), pattern);
    return compatibility(nearer, a.position, other, b.position) / -log(1.0 - max(u, 6e-8));  // u = 0 would be -log(1) = -0
}

/// Side of the square tiles in which the pixels of place i are paired. Their offsets have the root mean square of a disk's: side^2 / 3 =
/// radius^2 / 2. In every second place the radius is a third: where light is easily found and surfaces are glossy, far pixels' paths
/// are worth little.
uint tile_side(uint i)
{
    float radius = disk_radius(params.rules) * (i % 2u == 0u ? 1.0 : 1.0 / 3.0);
    return max(uint(round(radius * sqrt(1.5))), 2u);
}

/// The pixel that this one would be paired with in place i: of a pool of patterns the one of the largest bid; INVALID_INDEX: with none.
uint choose_partner(Seen centre, uint i)
{
    uint side = tile_side(i);
    uint chosen = INVALID_INDEX;
    float largest = 0.0;
    for (uint k = 0u; k < params.rules.pool; ++k) {
        uint pattern = i * MAX_POOL + k;
        uvec2 partner;
        if (!find_partner(centre.at, side, pattern, partner))
            continue;
        uint pixel = pixel_index(partner);
        if (primary_hit(params.surface, pixel).instance == INVALID_INDEX)
            continue;
        float bid = pair_bid(centre, see(partner), pattern);
        if (bid > largest) {
            largest = bid;
            chosen = pixel;
        }
    }
    return chosen;
}

/// What a pixel has chosen for place i. It is paired with it if that one has chosen it, too.
uint chosen_partner(uint pixel, uint i)
{
    return PartnerArray(params.partners).at[pixel * params.rules.neighbours + i];
}

#endif
