// The reservoir and the parameters of ReplayReuse. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_REPLAY_REUSE_SHARED_H
#define RESTIRPG_REPLAY_REUSE_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/restir/path_vertex_types.h"
RESTIRPG_SHARED

/// One direction, by the random numbers that drew it and as it was drawn.
struct ReplayReservoir {
    uint pixel;  ///< of its RandomKey; with `frame`, where its numbers come from
    uint frame;
    vec3 wi;
    float ucw;  ///< unbiased contribution weight: of the numbers (replayed), or of the direction, sr
    float confidence;
};

struct ReplayParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address guide;  ///< 0: unguided
    Address history;  ///< ReplayReservoir a pixel, one frame ago; 0: none
    Address reservoirs;  ///< ReplayReservoir a pixel, written; 0: nobody reads it
    Address samples;  ///< GuidingSample per pixel, written; 0: nobody reads it
    Address radiance;  ///< vec3 per pixel, written
    float alpha;  ///< probability of the BSDF
    float cap;  ///< of the history's confidence
    uint replay;  ///< 1: variant P, 0: variant U
};

RESTIRPG_SHARED_END
#endif
