// The light of each pixel's chosen path.
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "restir/path_reservoir.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReuseParameters params; };

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    uint pixel = at.y * frame.c.size.x + at.x;
    PathReservoir r = PathReservoirArray(params.source).at[pixel];
    Vec3Image(params.radiance).at[pixel] = r.f * r.ucw;
}
