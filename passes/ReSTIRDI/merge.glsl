// Merging reservoirs of several pixels into one: generalised resampled importance sampling with light points that are
// shared as they are.  [Lin et al. 2022, "Generalized Resampled Importance Sampling"; MIS weights: shaders/README]
//
// The participants are the centre (the pixel itself) and its neighbours (other pixels of this frame, or one of the
// frame before). A participant's domain is its surface as its own camera sees it; its target is the luminance that a
// point sends to the camera there, shadow ray included. Which pixels take part depends on the G-buffer alone, never on
// what their reservoirs hold.
#ifndef RESTIRPG_RESTIR_DI_MERGE_GLSL
#define RESTIRPG_RESTIR_DI_MERGE_GLSL

#include "Shared.h"
#include "restir/light_reservoir.glsl"
#include "restir/mis_weights.glsl"
#include "math/short_list.glsl"

// First addresses of what the numbers decide; candidate i has address i.
const uint RANDOM_RESAMPLING = 11u;  ///< dimension of a candidate: is it kept?
const uint RANDOM_MERGE = 0x10000u;  ///< + round: which reservoir a merge keeps
const uint RANDOM_PARTICIPANTS = 0x20000u;  ///< + round: which pixels take part
const uint RANDOM_POOLS = 0x40000u;  ///< see pool_round
const uint TEMPORAL_ROUND = 0xffffu;

RandomKey direct_key(uvec2 at)
{
    return random_key(picture_pixel(at), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_DIRECT);
}

/// Holder of a point: neighbour 0 ... count - 1, or the centre.
const uint CENTRE = MAX_NEIGHBOURS;

/// The surface of a pixel as its own camera saw it, and where that surface stands today.
struct Domain {
    ShadingPoint point;  ///< in the domain's frame
    RayEnd today;  ///< where the surface stands today
    bool previous;  ///< the domain's frame is the one before this
};

/// Who takes part in the merge. In private memory, because GLSL passes structs by value.
struct Merge {
    Domain centre;
    LightReservoir own;  ///< the centre's
    uint count;  ///< neighbours
    ShortList pixels;
    ShortList confidences;  ///< floats
    float total;  ///< confidence of all participants
    Address surfaces;  ///< PrimaryHit per pixel of the neighbours' frame
    LightReservoirArray reservoirs;  ///< of the neighbours
    bool previous;  ///< the neighbours are of the frame before
    bool pairwise;
};
Merge merge;

void begin_merge(Domain centre, LightReservoir own)
{
    merge.centre = centre;
    merge.own = own;
    merge.count = 0u;
    merge.total = own.confidence;
}

void add_neighbour(uint pixel, float confidence)
{
    list_set(merge.pixels, merge.count, pixel);
    list_set(merge.confidences, merge.count, floatBitsToUint(confidence));
    merge.count += 1u;
    merge.total += confidence;
}

uint neighbour_pixel(uint j)
{
    return list_get(merge.pixels, j);
}

float neighbour_confidence(uint j)
{
    return uintBitsToFloat(list_get(merge.confidences, j));
}

/// The domain of a pixel of this frame or the one before, by its primary hit.
Domain load_domain(Hit hit, bool previous)
{
    Surface today = load_surface(hit, false);
    Surface then = previous ? load_surface(hit, true) : today;
    vec3 camera = previous ? frame.c.previousCamera.position : frame.c.camera.position;
    ShadingPoint point = shade_surface(then, normalize(camera - then.position));
    return Domain(point, ray_end(today), previous);
}

/// Does nothing stand between the domain's surface and the point? Of the frame before, no acceleration structure is
/// left: the ray runs between the places where both ends stand today, so that neither hides behind itself.
bool is_seen(Domain d, LightPoint y)
{
    return is_lit(d.today, edge_to_light(y, d.today.position, false));
}

/// The target of a domain: p^(y) V(y).
float evaluate_target(Domain d, LightPoint y)
{
    float target = luminance(direct_contribution(d.point, edge_to_light(y, d.point.position, d.previous)));
    return target > 0.0 && is_seen(d, y) ? target : 0.0;
}

float target_at_centre(LightPoint y)
{
    return evaluate_target(merge.centre, y);
}

float target_at_neighbour(uint j, LightPoint y)
{
    return evaluate_target(load_domain(primary_hit(merge.surfaces, neighbour_pixel(j)), merge.previous), y);
}

/// Generalised balance heuristic: confidence times target, over the sum of that of all participants. `own`: the
/// holder's.
float balance_weight(float own, float here, uint holder, LightPoint y)
{
    float sum = own;
    if (holder != CENTRE)
        sum += merge.own.confidence * here;
    for (uint j = 0u; j < merge.count; ++j)
        if (j != holder)
            sum += neighbour_confidence(j) * target_at_neighbour(j, y);
    return own / sum;
}

/// A neighbour's share against the centre alone.
float share_of_neighbour(float there, float here)
{
    return pairwise_share(merge.total - merge.own.confidence, there, merge.own.confidence, here);
}

/// MIS weight of neighbour j for its point y, of target `there` in its own domain and `here` (> 0) at the centre.
float neighbour_weight(uint j, LightPoint y, float there, float here)
{
    if (merge.pairwise)
        return neighbour_confidence(j) / merge.total * share_of_neighbour(there, here);
    return balance_weight(neighbour_confidence(j) * there, here, j, y);
}

/// MIS weight of the centre for its point y, of target `here` (> 0). Pairwise: its own part, and what each neighbour
/// leaves to it.
float centre_weight(LightPoint y, float here)
{
    if (!merge.pairwise)
        return balance_weight(merge.own.confidence * here, here, CENTRE, y);
    float weight = merge.own.confidence / merge.total;
    for (uint j = 0u; j < merge.count; ++j)
        weight += neighbour_confidence(j) / merge.total * (1.0 - share_of_neighbour(target_at_neighbour(j, y), here));
    return weight;
}

/// The merged reservoir.
LightReservoir merge_reservoirs(RandomKey key, uint round)
{
    LightReservoir kept = merge.own;
    kept.confidence = merge.total;
    float sum = 0.0;
    if (merge.own.ucw > 0.0)
        sum = centre_weight(kept.point, kept.target) * kept.target * kept.ucw;
    for (uint j = 0u; j < merge.count; ++j) {
        LightReservoir r = merge.reservoirs.at[neighbour_pixel(j)];
        float here = r.ucw > 0.0 ? target_at_centre(r.point) : 0.0;
        if (here <= 0.0)
            continue;
        float weight = neighbour_weight(j, r.point, r.target, here) * here * r.ucw;
        sum += weight;
        if (random1(key, RANDOM_MERGE + round, j) * sum < weight) {
            kept.point = r.point;
            kept.target = here;
        }
    }
    kept.ucw = sum > 0.0 ? sum / kept.target : 0.0;
    return kept;
}

#endif
