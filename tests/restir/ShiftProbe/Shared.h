// What the kernels of ShiftProbe are told, and what they tell of a path. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_SHIFT_PROBE_SHARED_H
#define RESTIRPG_SHIFT_PROBE_SHARED_H
#include "../../../passes/ReSTIRReuse/Shared.h"
RESTIRPG_SHARED

// Which domain a pixel's path is shifted to.
RESTIRPG_CONST WAY_STAY = 0u;  ///< its own
RESTIRPG_CONST WAY_NEIGHBOUR = 1u;  ///< of a pixel nearby
RESTIRPG_CONST WAY_PREVIOUS = 2u;  ///< of a pixel nearby in the frame before, under that frame's camera

struct ShiftProbeParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address previousSurface;  ///< PrimaryHit per pixel, one frame ago
    Address reservoirs;  ///< PathReservoir per pixel: the paths
    Address history;  ///< PathReservoir per pixel, one frame ago
    Address result;  ///< vec4 per pixel
    uint way;  ///< WAY_*
};

// How a round trip ends.
RESTIRPG_CONST TRIP_NO_PATH = 0u;
RESTIRPG_CONST TRIP_NO_IMAGE = 1u;  ///< the path has no image there: allowed
RESTIRPG_CONST TRIP_RETURNED = 2u;
RESTIRPG_CONST TRIP_LOST = 3u;  ///< the image has no image here
RESTIRPG_CONST TRIP_CHANGED = 4u;  ///< what came back has another shape, label or end
RESTIRPG_CONST TRIP_MISFILED = 5u;  ///< path or image is not classified as its domain would classify it

// Kind of a path: how it ends, in the lowest three bits, ...
RESTIRPG_CONST END_SURFACE = 0u;  ///< reconnects to a surface vertex
RESTIRPG_CONST END_EMITTER = 1u;  ///< reconnects to its light point
RESTIRPG_CONST END_ENVIRONMENT = 2u;
RESTIRPG_CONST END_PUNCTUAL = 3u;
RESTIRPG_CONST END_DELTA = 4u;  ///< k = none
// ... which bounces are replayed, ...
RESTIRPG_CONST PREFIX_COPIED = 8u;  ///< a smooth bounce, its direction copied
RESTIRPG_CONST PREFIX_DELTA_REFLECTION = 16u;
RESTIRPG_CONST PREFIX_DELTA_TRANSMISSION = 32u;
RESTIRPG_CONST PREFIX_SHARP_REFLECTION = 64u;
RESTIRPG_CONST PREFIX_SHARP_TRANSMISSION = 128u;
// ... and how it leaves x_{k-1} on the edge that reconnects.
RESTIRPG_CONST CONNECTION_SHARP = 256u;  ///< through a rough sharp lobe (to a light)
RESTIRPG_CONST CONNECTION_TRANSMITS = 512u;  ///< to the other side of the surface

RESTIRPG_SHARED_END
#endif
