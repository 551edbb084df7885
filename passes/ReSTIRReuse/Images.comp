// The image that the path of each of a pixel's partners has in this pixel. A shift is made once, and serves both pixels: the one as a path
// to take, the other as its own path's target there.
#version 460
#define RECIPROCAL 1
#include "prelude.glsl"
#include "participants.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    if (hit.instance == INVALID_INDEX)
        return;
    Neighbours neighbours = find_neighbours(at);
    ShadingPoint here = domain_today(hit, false);
    [[dont_unroll]] for (uint i = 0u; i < params.rules.neighbours; ++i) {
        uint partner = list_get(neighbours.pixels, i);
        if (partner == INVALID_INDEX)
            continue;
        PathReservoir shifted;
        float jacobian;
        if (!shift_to(PathReservoirArray(params.source).at[partner], here, shifted, jacobian))
            jacobian = 0.0;
        PathImageArray(params.images).at[pixel * params.rules.neighbours + i] =
            PathImage(shifted.f, shifted.geometry, jacobian, shifted.anchor, shifted.place);
    }
}
