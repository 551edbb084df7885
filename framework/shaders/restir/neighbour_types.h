// How pixels find the pixels that they merge with: part of the parameters of ReSTIRDI and ReSTIRReuse.
#ifndef RESTIRPG_NEIGHBOUR_TYPES_H
#define RESTIRPG_NEIGHBOUR_TYPES_H
#include "shaders/math/short_list_types.h"
RESTIRPG_SHARED

/// Neighbours that one pixel can merge in one round: as many as a ShortList holds.
RESTIRPG_CONST MAX_NEIGHBOURS = SHORT_LIST_SIZE;
RESTIRPG_CONST MAX_POOL = 32u;

struct NeighbourRules {
    uint neighbours;  ///< drawn in one round
    uint pool;  ///< pixels (or pairs) that one of them is chosen from; 1: the one that is drawn
    float radius;  ///< of the disk, see disk_radius
    float leastRadius;  ///< of the disk, pixels of this image
    float normalThreshold;  ///< least cosine between normals of merged pixels
    float depthThreshold;  ///< most relative difference of their distances from the camera
};

RESTIRPG_SHARED_END
#endif
