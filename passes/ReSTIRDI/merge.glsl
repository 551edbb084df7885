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
#include "scene/primary_hit.glsl"
#include "restir/light_reservoir.glsl"
#include "restir/resampling.glsl"
#include "math/short_list.glsl"

// First addresses of what the numbers decide; candidate i has address i.
const uint RANDOM_RESAMPLING = 11u;  ///< dimension of a candidate: is it kept?
const uint RANDOM_MERGE = 0x10000u;  ///< + round: which reservoir a merge keeps
const uint RANDOM_PARTICIPANTS = 0x20000u;  ///< + round: which pixels take part
const uint RANDOM_POOLS = 0x40000u;  ///< + those of a round: see pool_round

RandomKey direct_key(uvec2 at)
{
    return random_key(picture_pixel(at), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_DIRECT);
}

// A participant's number: 0 is the centre, 1 ... count are its neighbours.
const uint CENTRE = 0u;

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
    bool shade;  ///< `light` is wanted
    vec3 light;  ///< sum of MIS weight, contribution and contribution weight of each point, W/sr/m^2; its luminance is the weights' sum
};
Merge merge;

void begin_merge(Domain centre, LightReservoir own)
{
    merge.centre = centre;
    merge.own = own;
    merge.count = 0u;
    merge.total = own.confidence;
    merge.light = vec3(0.0);
}

void add_neighbour(uint pixel, float confidence)
{
    list_set(merge.pixels, merge.count, pixel);
    list_set(merge.confidences, merge.count, floatBitsToUint(confidence));
    merge.count += 1u;
    merge.total += confidence;
}

/// The pixel of a neighbour.
uint pixel_of(uint participant)
{
    return list_get(merge.pixels, participant - 1u);
}

float confidence_of(uint participant)
{
    return participant == CENTRE ? merge.own.confidence : uintBitsToFloat(list_get(merge.confidences, participant - 1u));
}

/// The domain of a pixel of this frame or the one before, by its primary hit.
Domain load_domain(Hit hit, bool previous)
{
    Surface today = load_surface(hit, false);
    Surface then = previous ? load_surface(hit, true) : today;
    vec3 camera = previous ? frame.c.previousCamera.position : frame.c.camera.position;
    return Domain(shade_for_camera(then, camera), ray_end(today), previous);
}

/// The light that a point sends to the camera in a participant's domain. `seen`: the point is known to be visible there.
/// The acceleration structure is today's, also for a domain of the frame before: the ray runs between the places where
/// both ends stand today, so that neither hides behind itself.
vec3 light_at(uint participant, LightPoint y, bool seen)
{
    Domain d = merge.centre;
    if (participant != CENTRE)
        d = load_domain(primary_hit(merge.surfaces, pixel_of(participant)), merge.previous);
    vec3 light = direct_contribution(d.point, edge_to_light(y, d.point.position, d.previous));
    return seen || luminance(light) > 0.0 && is_free(shadow_ray_to_light(d.today, y)) ? light : vec3(0.0);
}

/// Pairwise MIS: a neighbour's share of a point against the centre alone, by the targets in the domains of both.
float share_of_neighbour(float there, float here)
{
    return pairwise_share(merge.total - merge.own.confidence, there, merge.own.confidence, here);
}

/// MIS weight of a participant for the point it holds. `here`: the point's target at the centre; the centre takes no
/// point that has none there. `light`: what the target is the luminance of; of the centre's own point only if the merge
/// shades. Every use of a target stands in this one loop: drivers copy a function to each of its calls, and a target is
/// most of the kernel.
float mis_weight(uint holder, LightReservoir r, out float here, out vec3 light)
{
    here = r.target;
    light = vec3(0.0);
    float own = confidence_of(holder) * r.target;
    float all = own;  // confidence times target, of all participants: the balance heuristic's denominator
    float part = confidence_of(holder) / merge.total;  // pairwise: of the point's weight
    for (uint i = 0u; i <= merge.count; ++i) {
        bool own_domain = i == holder;
        if (own_domain && !(i == CENTRE && merge.shade))
            continue;
        vec3 sent = light_at(i, r.point, own_domain);
        if (i == CENTRE)
            light = sent;
        if (own_domain)
            continue;
        float there = luminance(sent);
        if (i == CENTRE) {
            here = there;
            if (here <= 0.0 || merge.pairwise)  // pairwise, a neighbour shares its points with the centre alone
                break;
        }
        all += confidence_of(i) * there;
        if (holder == CENTRE)  // what a neighbour leaves to the centre
            part += confidence_of(i) / merge.total * (1.0 - share_of_neighbour(there, here));
    }
    if (!merge.pairwise)
        return own / all;
    return holder == CENTRE ? part : part * share_of_neighbour(r.target, here);
}

/// The merged reservoir.
LightReservoir merge_reservoirs(RandomKey key, uint round)
{
    LightReservoir kept = merge.own;
    float sum = 0.0;
    for (uint i = 0u; i <= merge.count; ++i) {
        LightReservoir r = merge.own;
        if (i != CENTRE)
            r = merge.reservoirs.at[pixel_of(i)];
        if (r.ucw <= 0.0)
            continue;
        float here;
        vec3 light;
        float mis = mis_weight(i, r, here, light);
        if (here <= 0.0)
            continue;
        float weight = mis * here * r.ucw;
        merge.light += mis * r.ucw * light;
        if (resample(sum, weight, i == CENTRE ? 0.0 : random1(key, RANDOM_MERGE + round, i - 1u))) {
            kept.point = r.point;
            kept.target = here;
        }
    }
    kept.confidence = merge.total;
    kept.ucw = sum > 0.0 ? sum / kept.target : 0.0;
    return kept;
}

#endif
