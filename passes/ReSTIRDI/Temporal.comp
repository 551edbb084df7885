// Merges the pixel's reservoir with that of the pixel that showed the same surface in the frame before.
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
    merge.light = vec3(0.0);
    if (hit.instance != INVALID_INDEX) {
        LightReservoirArray reservoirs = LightReservoirArray(params.reservoirs);
        merge.surfaces = params.previousSurface;
        merge.reservoirs = LightReservoirArray(params.history);
        merge.previous = true;
        merge.pairwise = false;  // of two participants, the balance heuristic costs no more
        merge.shade = params.radiance != 0ul;
        begin_merge(load_domain(hit, false), reservoirs.at[pixel]);
        RandomKey key = direct_key(at);
        add_previous(key, at, hit, Vec2Image(params.motion).at[pixel]);
        if (merge.count > 0u || merge.shade)
            reservoirs.at[pixel] = merge_reservoirs(key, TEMPORAL_ROUND);
    }
    if (params.radiance != 0ul)
        Vec3Image(params.radiance).at[pixel] = merge.light;
}
