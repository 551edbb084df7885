#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "scene/surface.glsl"
#include "trace/trace.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { LeaveSurfaceParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer DepartureArray { Departure at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ArrivalArray { Arrival at[]; };

void main()
{
    frame = FrameRef(params.frame);
    uint i = gl_GlobalInvocationID.x;
    if (i >= params.count)
        return;
    Departure departure = DepartureArray(params.departures).at[i];
    RayEnd x = ray_end(load_surface(departure.from, false));
    Arrival arrival;
    arrival.clearance = x.clearance;
    if (departure.to.instance == INVALID_INDEX) {
        trace_closest(leave_surface(x, departure.direction), departure.direction, RAY_INFINITY, arrival.hit, arrival.t);
    } else {
        ShadowRay ray = shadow_ray(x, ray_end(load_surface(departure.to, false)));
        trace_closest(ray.origin, ray.direction, ray.t_max, arrival.hit, arrival.t);
    }
    ArrivalArray(params.arrivals).at[i] = arrival;
}
