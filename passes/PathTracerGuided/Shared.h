// Parameters of the kernels of PathTracerGuided.
#ifndef RESTIRPG_PATH_TRACER_GUIDED_SHARED_H
#define RESTIRPG_PATH_TRACER_GUIDED_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct PathTracerParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address radiance;  ///< vec3 per pixel; 0: nobody reads it
    Address candidates;  ///< PathReservoir per pixel; 0: nobody reads it
    Address guide;  ///< what the guide's module reads; 0: no guide
    Address samples;  ///< GuidingSample, guidedBounces per tree; 0: nobody reads them
    uint bounces;  ///< the bounce cap n: paths of at most n + 2 edges
    uint nextEventEstimation;  ///< 1: connect every vertex to a light, weighted against scattering
    uint direct;  ///< 1: direct light at the primary hit is part of the result
    float alpha;  ///< probability of sampling a smooth bounce by the BSDF where there is guidance
    uint trees;  ///< path trees per pixel
    uint guidedBounces;  ///< bounces that the guide draws, and that samples has, at most bounces + 1
};

RESTIRPG_SHARED_END
#endif
