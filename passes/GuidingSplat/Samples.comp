// Adds the bounces of raw path trees, weighted by the light that came back along them.
#version 460
#include "prelude.glsl"
#include "splat.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at;
    GuidingGrid grid;
    if (!begin_splat(at, grid))
        return;
    GuidingSample given = GuidingSampleArray(params.samples).at[pixel_index(at) * params.stride + gl_GlobalInvocationID.z];
    if (is_valid(given.vertex) && given.weight > 0.0)
        add_sample(grid, make_sample(given.vertex, given.weight, given.distance));
}
