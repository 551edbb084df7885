// The partner that each pixel would have in each place. Two pixels that choose each other are paired.
#version 460
#include "prelude.glsl"
#include "pairs.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    bool has_surface = primary_hit(params.surface, pixel).instance != INVALID_INDEX;
    Seen centre = see(at);
    for (uint i = 0u; i < params.rules.neighbours; ++i)
        PartnerArray(params.partners).at[pixel * params.rules.neighbours + i] = has_surface ? choose_partner(centre, i) : INVALID_INDEX;
}
