// Parameters of trace_rays.comp and leave_surface.comp.
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

/// A ray that leaves the surface at `from`: in the direction or, if it is a hit, towards `to`.
struct Departure {
    Hit from;
    Hit to;
    vec3 direction;
};

/// What it meets; in the second case before it arrives.
struct Arrival {
    Hit hit;
    float t;
    float clearance;  ///< where it left
};

struct LeaveSurfaceParameters {
    Address frame;
    Address departures;  ///< Departure
    Address arrivals;  ///< Arrival
    uint count;
};

RESTIRPG_SHARED_END
#endif
