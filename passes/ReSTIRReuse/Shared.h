// Parameters of the kernels of ReSTIRReuse.
#ifndef RESTIRPG_RESTIR_REUSE_SHARED_H
#define RESTIRPG_RESTIR_REUSE_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/path_reservoir_types.h"
RESTIRPG_SHARED

struct ReuseParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< Hit a pixel
    Address previousSurface;  ///< Hit a pixel, one frame ago
    Address motion;  ///< vec2 a pixel
    Address source;  ///< PathReservoir a pixel, read
    Address history;  ///< PathReservoir a pixel, one frame ago
    Address reservoirs;  ///< PathReservoir a pixel, written
    Address radiance;  ///< vec3 a pixel; 0: nobody reads it
    Address vertexSource;  ///< PathVertex of `source`, stride a pixel; 0: nobody reads vertices
    Address vertexHistory;  ///< PathVertex of `history`
    Address vertices;  ///< PathVertex of `reservoirs`, written
    float cap;  ///< confidence of the history, at most, times that of the pixel's own
    float radius;  ///< pixels
    float normalThreshold;
    float depthThreshold;
    uint neighbours;
    uint round;
    uint stride;  ///< vertices a pixel
};

RESTIRPG_CONST MAX_REUSE_NEIGHBOURS = 16u;

// What the knob `fault` builds in, in the order of its choices.
RESTIRPG_CONST REUSE_FAULT_NONE = 0u;
RESTIRPG_CONST REUSE_FAULT_JACOBIAN = 1u;  ///< every shift's Jacobian is 1
RESTIRPG_CONST REUSE_FAULT_MIS = 2u;  ///< the history's target in its own domain is taken without the Jacobian
RESTIRPG_CONST REUSE_FAULT_CAP = 3u;  ///< MIS weights use the confidence before the cap
RESTIRPG_CONST REUSE_FAULT_PREVIOUS_CAMERA = 4u;  ///< the previous frame's surfaces are seen by this frame's camera
RESTIRPG_CONST REUSE_FAULT_CONFIDENCE = 5u;  ///< pixels without a sample take no part

RESTIRPG_SHARED_END
#endif
