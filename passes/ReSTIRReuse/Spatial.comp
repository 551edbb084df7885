// One round of merging each pixel's reservoir with those of pixels around it, by defensive pairwise MIS with confidences
// [shaders/README: MIS weights]: a neighbour competes with the centre alone, so that n neighbours take 2 n shifts.
#version 460
#include "prelude.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReuseParameters params; };

/// Who takes part besides the centre.
struct Neighbours {
    uint count;
    uint pixel[MAX_REUSE_NEIGHBOURS];
    float confidence;  ///< of all of them
};

Neighbours find_neighbours(uvec2 at, Hit hit)
{
    Neighbours n;
    n.count = 0u;
    n.confidence = 0.0;
    Surface centre = load_surface(hit, false);
    float radius = disk_radius(params.radius);
    for (uint i = 0u; i < params.neighbours; ++i) {
        uint pixel;
        if (!find_neighbour_pixel(at, radius, random2(reuse_key(at), spatial_round(params.round), 2u * i), pixel))
            continue;
        Hit there = HitArray(params.surface).at[pixel];
        if (there.instance == INVALID_INDEX || !is_similar(centre, load_surface(there, false), frame.c.camera.position,
                                                           params.normalThreshold, params.depthThreshold))
            continue;
        n.pixel[n.count++] = pixel;
        n.confidence += PathReservoirArray(params.source).at[pixel].confidence;
    }
    return n;
}

Choice merge_neighbours(uvec2 at, Hit hit, Choice kept, Neighbours n)
{
    PathReservoir own = kept.path;
    uint centre = kept.owner;
    ShadingPoint here = load_domain(hit, false);
    float total = own.confidence + n.confidence;
    float own_weight = own.confidence / total;
    for (uint i = 0u; i < n.count; ++i) {
        PathReservoir r = PathReservoirArray(params.source).at[n.pixel[i]];
        ShadingPoint there = load_domain(HitArray(params.surface).at[n.pixel[i]], false);
        float part = r.confidence / total;
        own_weight += part * share_left(own, there, own.confidence, n.confidence);
        PathReservoir shifted;
        float jacobian;
        if (!shift_to(r, here, shifted, jacobian))
            continue;
        float share = neighbour_share(r, shifted, jacobian, own.confidence, n.confidence);
        float weight = part * share * luminance(shifted.f) * jacobian * r.ucw;
        choose(kept, shifted, n.pixel[i], weight, random1(reuse_key(at), spatial_round(params.round), 2u * i + 1u));
    }
    // The centre comes last: its weight is known only now.
    choose(kept, own, centre, own_weight * luminance(own.f) * own.ucw,
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
    Hit hit = HitArray(params.surface).at[pixel];
    Choice kept = Choice(PathReservoirArray(params.source).at[pixel], 0.0, pixel);
    if (hit.instance != INVALID_INDEX) {
        Neighbours n = find_neighbours(at, hit);
        if (n.count > 0u)
            kept = merge_neighbours(at, hit, kept, n);
    }
    PathReservoirArray(params.reservoirs).at[pixel] = kept.path;
    write_origin(params.origins, pixel, origin_of(params.originSource, kept.owner));
}
