// Parameters of the kernels of ReSTIRReuse.
#ifndef RESTIRPG_RESTIR_REUSE_SHARED_H
#define RESTIRPG_RESTIR_REUSE_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/restir/neighbour_types.h"
#include "shaders/restir/path_reservoir_types.h"
RESTIRPG_SHARED

struct ReuseParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address previousSurface;  ///< PrimaryHit per pixel, one frame ago
    Address motion;  ///< vec2 per pixel
    Address source;  ///< PathReservoir per pixel, read
    Address history;  ///< PathReservoir per pixel, one frame ago
    Address reservoirs;  ///< PathReservoir per pixel, written
    Address radiance;  ///< vec3 per pixel, written; 0: not by this kernel
    Address images;  ///< PathImage, one per pixel and partner; 0: pixels are not paired
    Address partners;  ///< the pixel that each pixel would be paired with in each place, a uint; INVALID_INDEX: none
    float cap;  ///< confidence of the history, at most, times that of the pixel's own
    uint round;  ///< of spatial reuse
    NeighbourRules rules;
};

/// What a path's image in another pixel does not share with the path. 36 bytes.
struct PathImage {
    vec3 f;
    float geometry;
    float jacobian;  ///< of the shift; 0: there is no image
    uvec2 anchor;
    vec2 place;
};

RESTIRPG_SHARED_END
#endif
