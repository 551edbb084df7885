// Adds the bounces of each pixel's path, as far as its reservoir tells them.
#version 460
#include "prelude.glsl"
#include "splat.glsl"
#include "restir/path_walk.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

bool is_wanted(PathVertex v)
{
    if (!is_valid(v))
        return false;
    if ((v.surface & VERTEX_FINAL) == 0u || params.finalEdges == FINAL_EDGES_ALL)
        return true;
    return params.finalEdges == FINAL_EDGES_SCATTERED && (v.surface & VERTEX_LIGHT_SAMPLED) == 0u;
}

void main()
{
    uvec2 at;
    GuidingGrid grid;
    if (!begin_splat(at, grid))
        return;
    uint pixel = pixel_index(at);
    PathReservoir r = PathReservoirArray(params.paths).at[pixel];
    if (r.ucw <= 0.0)
        return;
    PathWalk walk = begin_walk(primary_hit(params.surface, pixel));
    bool valued = params.incident != 0u || learns_alpha();
    PathVertex v;
    while (walk_bounce(r, params.learnedBounces, valued, walk, v)) {
        if (is_wanted(v))
            add_sample(grid, make_sample(v, params.incident != 0u ? 1.0 / vertex_scatter(v) : 1.0, 0.0));
    }
}
