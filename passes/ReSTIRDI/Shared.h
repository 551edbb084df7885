// Parameters of ReSTIRDI's kernels.
#ifndef RESTIRPG_RESTIR_DI_SHARED_H
#define RESTIRPG_RESTIR_DI_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/restir/light_reservoir_types.h"
RESTIRPG_SHARED

/// Neighbours that one pixel can merge in one round: the arrays of merge.glsl have this length.
RESTIRPG_CONST MAX_NEIGHBOURS = 16u;
RESTIRPG_CONST MAX_POOL = 32u;

/// Push constants of every kernel of the pass; each reads what it needs.
struct ReSTIRDIParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address previousSurface;  ///< PrimaryHit per pixel, of the frame before
    Address motion;  ///< vec2 per pixel
    Address history;  ///< LightReservoir per pixel, of the frame before
    Address source;  ///< LightReservoir per pixel, read by Spatial.comp and Shade.comp
    Address reservoirs;  ///< LightReservoir per pixel, written; Temporal.comp reads it too
    Address radiance;  ///< vec3 per pixel
    uint candidates;  ///< light candidates per pixel
    uint bsdfCandidates;
    uint round;  ///< of spatial reuse
    uint neighbours;  ///< drawn in one round
    uint pairwise;  ///< 1: pairwise MIS, 0: balance heuristic
    float cap;  ///< confidence of the history, in candidate sets
    float radius;  ///< of the disk of neighbours, see disk_radius
    float normalThreshold;  ///< least cosine between normals of merged pixels
    float depthThreshold;  ///< most relative difference of their distances from the camera
    float leastRadius;  ///< of the disk, pixels of this image
    uint pool;  ///< pixels that a neighbour is chosen from; 1: each neighbour is drawn uniformly
};

RESTIRPG_SHARED_END
#endif
