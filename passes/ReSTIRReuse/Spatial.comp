// One round of merging each pixel's reservoir with those of pixels around it, by defensive pairwise MIS with confidences
// [shaders/README: MIS weights]: a neighbour competes with the centre alone, so that n neighbours take 2 n shifts, or n where pixels are
// paired.
#version 460
#include "prelude.glsl"
#include "participants.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

/// The image in a pixel, whose surface is `domain`, of path y of its neighbour number i; false: it has none there.
bool image_in(uint pixel, ShadingPoint domain, uint i, PathReservoir y, out PathReservoir shifted, out float jacobian)
{
#if RECIPROCAL
    PathImage image = PathImageArray(params.images).at[pixel * params.rules.neighbours + i];
    shifted = with_image(y, image);
    jacobian = image.jacobian;
    return jacobian > 0.0;
#else
    return shift_to(y, domain, shifted, jacobian);
#endif
}

Choice merge_neighbours(uvec2 at, uint centre, Hit hit, Neighbours neighbours, PathReservoir own)
{
    Choice kept = begin_merge(own);
    ShadingPoint here = domain_today(hit, false);
    float others = neighbours.confidence;
    float total = own.confidence + others;
    float own_weight = own.confidence / total;
    // Each neighbour makes two images: the centre's path there, the neighbour's path here. One place calls the shift, for compilers copy
    // its code to each.
    [[dont_unroll]] for (uint i = 0u; i < 2u * params.rules.neighbours; ++i) {
        bool outwards = (i & 1u) == 0u;
        uint pixel = list_get(neighbours.pixels, i / 2u);
        if (pixel == INVALID_INDEX)
            continue;
        PathReservoir y = PathReservoirArray(params.source).at[pixel];
        float part = y.confidence / total;
        ShadingPoint domain = here;
        uint to = centre;
        if (outwards) {
            y = own;
            to = pixel;
            domain = domain_today(primary_hit(params.surface, pixel), false);
        }
        PathReservoir shifted;
        float jacobian;
        bool has_image = image_in(to, domain, i / 2u, y, shifted, jacobian);
        float target = has_image ? luminance(shifted.f) * jacobian : 0.0;
        if (outwards) {
            own_weight += part * share_left(own, target, own.confidence, others);
        } else if (has_image) {
            float weight = part * neighbour_share(y, shifted, jacobian, own.confidence, others) * target * y.ucw;
            choose(kept, shifted, weight, random1(reuse_key(at), spatial_round(params.round), i));
        }
    }
    // The centre comes last: its weight is known only now.
    choose(kept, own, own_weight * luminance(own.f) * own.ucw,
           random1(reuse_key(at), spatial_round(params.round), SPATIAL_NUMBERS - 1u));
    finish_merge(kept, total);
    return kept;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    Choice kept = keep(PathReservoirArray(params.source).at[pixel]);
    if (hit.instance != INVALID_INDEX) {
        Neighbours neighbours = find_neighbours(at);
        if (neighbours.any)
            kept = merge_neighbours(at, pixel, hit, neighbours, kept.path);
    }
    write_choice(params, pixel, kept);
}
