#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "trace/trace.glsl"

struct Ray {
    vec3 origin;
    vec3 direction;
    float t_max;
};
struct TracedHit {
    Hit hit;
    float t;
};

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { TraceRaysParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer RayArray { Ray at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer TracedHitArray { TracedHit at[]; };

void main()
{
    frame = FrameRef(params.frame);
    uint i = gl_GlobalInvocationID.x;
    if (i >= params.count)
        return;
    Ray ray = RayArray(params.rays).at[i];
    TracedHit result;
#if ANY
    result.hit = Hit(trace_any(ray.origin, ray.direction, ray.t_max) ? 0u : INVALID_INDEX, 0u, vec2(0.0));
    result.t = 0.0;
#else
    trace_closest(ray.origin, ray.direction, ray.t_max, result.hit, result.t);
#endif
    TracedHitArray(params.hits).at[i] = result;
}
