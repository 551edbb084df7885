// Parameters of trace_rays.comp.
#ifndef RESTIRPG_TEST_TRACE_SHARED_H
#define RESTIRPG_TEST_TRACE_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct TraceRaysParameters {
    Address frame;
    Address rays;  ///< vec3 origin, vec3 direction, float length
    Address hits;  ///< Hit, float t
    uint count;
};

RESTIRPG_SHARED_END
#endif
