// Which pixels a pixel merges with in a round of spatial reuse. Compiled with RECIPROCAL = 1, pixels are paired; else each draws its own.
#ifndef RESTIRPG_RESTIR_REUSE_PARTICIPANTS_GLSL
#define RESTIRPG_RESTIR_REUSE_PARTICIPANTS_GLSL

#include "merge.glsl"
#include "short_list.glsl"

#ifndef RECIPROCAL
#define RECIPROCAL 0
#endif

/// A pixel's partner number i, whose partner i is this pixel [shaders/README: Reciprocal pairs]. false: it would be outside of the image, or
/// the pixel itself.
bool find_partner(uvec2 at, uint side, uint i, out uint pixel)
{
    const uint NO_PIXEL = 0xffffffffu;
    RandomKey key = RandomKey(NO_PIXEL, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE);
    uvec2 shift = uvec2(random2(key, partner_round(params.round), i) * float(side));
    uvec2 tile = (at + shift) / side;
    uvec2 place = (at + shift) % side;
    uvec2 turn = uvec2(random2(random_key(tile, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE), partner_round(params.round), i) * float(side));
    ivec2 found = ivec2(tile * side + (turn + side - place) % side) - ivec2(shift);
    pixel = 0u;
    if (any(lessThan(found, ivec2(0))) || any(greaterThanEqual(found, ivec2(frame.c.size))) || found == ivec2(at))
        return false;
    pixel = uint(found.y) * frame.c.size.x + uint(found.x);
    return true;
}

/// Neighbour i of the pixel, if there is one whose surface is similar.
bool find_neighbour(uvec2 at, Appearance centre, uint i, out uint pixel)
{
    float radius = disk_radius(params.radius, params.leastRadius);
    NeighbourRules rules = NeighbourRules(radius, params.pool, params.normalThreshold, params.depthThreshold);
    Appearance there;
#if RECIPROCAL
    // The offsets have the disk's root mean square: side^2 / 3 = radius^2 / 2.
    if (!find_partner(at, max(uint(round(radius * sqrt(1.5))), 2u), i, pixel) || primary_hit(params.surface, pixel).instance == INVALID_INDEX)
        return false;
    there = load_appearance(params.surface, pixel);
    return is_similar(centre, there, rules.normal_threshold, rules.depth_threshold) &&
           is_similar(there, centre, rules.normal_threshold, rules.depth_threshold);
#else
    if (params.pool > 1u)
        return choose_compatible(params.surface, at, centre, rules, reuse_key(at), pool_round(params.round), i * MAX_REUSE_POOL, pixel);
    return draw_neighbour(params.surface, at, centre, rules, random2(reuse_key(at), spatial_round(params.round), 2u * i), pixel, there);
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
    Appearance centre = load_appearance(params.surface, at.y * frame.c.size.x + at.x);
    Neighbours found = Neighbours(ShortList(uvec4(0u), uvec4(0u), uvec4(0u), uvec4(0u)), 0.0, false);
    for (uint i = 0u; i < params.neighbours; ++i) {
        uint pixel;
        if (find_neighbour(at, centre, i, pixel)) {
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
    y.sharpPdf = image.sharpPdf;
    y.anchor = image.anchor;
    y.place = image.place;
    return y;
}

#endif
