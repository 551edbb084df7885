// The bounces that each pixel's reservoir tells of its path.
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "restir/path_walk.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { PathVerticesParameters params; };

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    PathVertexArray vertices = PathVertexArray(params.vertices);
    uint next = pixel * PATH_TOLD;
    uint end = next + PATH_TOLD;
    PathReservoir r = PathReservoirArray(params.paths).at[pixel];
    if (r.ucw > 0.0) {
        PathWalk walk = begin_walk(primary_hit(params.surface, pixel));
        PathVertex v;
        while (walk_bounce(r, PATH_TOLD, true, walk, v))
            vertices.at[next++] = v;
    }
    while (next < end)
        vertices.at[next++] = no_path_vertex();
}
