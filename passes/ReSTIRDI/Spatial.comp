// One round of merging the pixel's reservoir with those of pixels around it.
#version 460
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
    LightReservoir r = LightReservoirArray(params.source).at[pixel];
    merge.light = vec3(0.0);
    if (hit.instance != INVALID_INDEX) {
        merge.surfaces = params.surface;
        merge.reservoirs = LightReservoirArray(params.source);
        merge.previous = false;
        merge.pairwise = params.pairwise != 0u;
        merge.shade = params.radiance != 0ul;
        begin_merge(load_domain(hit, false), r);
        RandomKey key = direct_key(at);
        add_around(key, at);
        if (merge.count > 0u || merge.shade)
            r = merge_reservoirs(key, params.round);
    }
    if (params.radiance != 0ul)
        Vec3Image(params.radiance).at[pixel] = merge.light;
    LightReservoirArray(params.reservoirs).at[pixel] = r;
}
