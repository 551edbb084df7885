// One round of merging each pixel's reservoir with those of pixels around it, by defensive pairwise MIS with confidences
// [shaders/README: MIS weights]: a neighbour competes with the centre alone, so that n neighbours take 2 n shifts.
#version 460
#include "prelude.glsl"
#include "merge.glsl"
#include "short_list.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReuseParameters params; };

/// Neighbour i of the pixel, if there is one.
bool find_neighbour(uvec2 at, Appearance centre, uint i, out uint pixel)
{
    NeighbourRules rules = NeighbourRules(disk_radius(params.radius, params.leastRadius), params.pool, params.normalThreshold, params.depthThreshold);
    if (params.pool > 1u)
        return choose_compatible(params.surface, at, centre, rules, reuse_key(at), pool_round(params.round), i * MAX_REUSE_POOL, pixel);
    Appearance there;
    return draw_neighbour(params.surface, at, centre, rules, random2(reuse_key(at), spatial_round(params.round), 2u * i), pixel, there);
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

Choice merge_neighbours(uvec2 at, Hit hit, Neighbours neighbours, Choice kept)
{
    PathReservoir own = kept.path;
    uint owner = kept.owner;
    ShadingPoint here = load_domain(hit, false);
    float others = neighbours.confidence;
    float total = own.confidence + others;
    float own_weight = own.confidence / total;
    // Of each neighbour two shifts: the centre's path there, the neighbour's path here. One place calls the shift, for compilers copy
    // its code to each.
    [[dont_unroll]] for (uint i = 0u; i < 2u * params.neighbours; ++i) {
        bool outwards = (i & 1u) == 0u;
        uint pixel = list_get(neighbours.pixels, i / 2u);
        if (pixel == INVALID_INDEX)
            continue;
        PathReservoir y = PathReservoirArray(params.source).at[pixel];
        float part = y.confidence / total;
        ShadingPoint domain = here;
        if (outwards) {
            y = own;
            domain = load_domain(primary_hit(params.surface, pixel), false);
        }
        PathReservoir shifted;
        float jacobian;
        bool has_image = shift_to(y, domain, shifted, jacobian);
        float target = has_image ? luminance(shifted.f) * jacobian : 0.0;
        if (outwards) {
            own_weight += part * share_left(own, target, own.confidence, others);
        } else if (has_image) {
            float weight = part * neighbour_share(y, shifted, jacobian, own.confidence, others) * target * y.ucw;
            choose(kept, shifted, pixel, weight, random1(reuse_key(at), spatial_round(params.round), i));
        }
    }
    // The centre comes last: its weight is known only now.
    choose(kept, own, owner, own_weight * luminance(own.f) * own.ucw,
           random1(reuse_key(at), spatial_round(params.round), SPATIAL_NUMBERS - 1u));
    finish_merge(kept, total);
    return kept;
}

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    uint pixel = at.y * frame.c.size.x + at.x;
    Hit hit = primary_hit(params.surface, pixel);
    Choice kept = Choice(PathReservoirArray(params.source).at[pixel], 0.0, pixel);
    if (hit.instance != INVALID_INDEX) {
        Neighbours neighbours = find_neighbours(at);
        if (neighbours.any)
            kept = merge_neighbours(at, hit, neighbours, kept);
    }
    PathReservoirArray(params.reservoirs).at[pixel] = kept.path;
    write_origin(params.origins, pixel, origin_of(params.originSource, kept.owner));
}
