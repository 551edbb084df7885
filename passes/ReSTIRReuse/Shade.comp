// The light of each pixel's chosen path.
#version 460
#include "prelude.glsl"
#include "push.glsl"
#include "restir/path_reservoir.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    PathReservoir r = PathReservoirArray(params.source).at[pixel];
    Vec3Image(params.radiance).at[pixel] = r.f * r.ucw;
}
