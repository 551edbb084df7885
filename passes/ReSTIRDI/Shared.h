// Parameters of ReSTIRDI's kernels.
#ifndef RESTIRPG_RESTIR_DI_SHARED_H
#define RESTIRPG_RESTIR_DI_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/restir/light_reservoir_types.h"
#include "shaders/restir/neighbour_types.h"
RESTIRPG_SHARED

/// Push constants of every kernel of the pass; each reads what it needs.
struct ReSTIRDIParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address previousSurface;  ///< PrimaryHit per pixel, of the frame before
    Address motion;  ///< vec2 per pixel
    Address history;  ///< LightReservoir per pixel, of the frame before
    Address source;  ///< LightReservoir per pixel, read by Spatial.comp and Shade.comp
    Address reservoirs;  ///< LightReservoir per pixel, written; Temporal.comp reads it too
    Address radiance;  ///< vec3 per pixel, written; 0: not by this kernel
    uint candidates;  ///< light candidates per pixel
    uint bsdfCandidates;
    uint round;  ///< of spatial reuse
    uint pairwise;  ///< 1: pairwise MIS, 0: balance heuristic
    float cap;  ///< confidence of the history, in candidate sets
    NeighbourRules rules;
};

RESTIRPG_SHARED_END
#endif
