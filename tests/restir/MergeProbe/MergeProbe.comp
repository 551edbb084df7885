// The MIS weights of one point, over all who could hold it, add up to 1: whichever participant made the point.
#version 460
#include "prelude.glsl"
#include "../../../passes/ReSTIRDI/participants.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

/// The reservoir with which a participant would hold the point: the kernel of its own frame stores the target as its
/// camera saw the surface.
LightReservoir held_by(uint participant, LightPoint y)
{
    LightReservoir r = merge.own;
    Domain d = merge.centre;
    if (participant != CENTRE) {
        r = merge.reservoirs.at[pixel_of(participant)];
        Hit hit = primary_hit(merge.surfaces, pixel_of(participant));
        Surface today = load_surface(hit, false);
        Surface then = load_surface(hit, merge.previous);
        vec3 camera = merge.previous ? frame.c.previousCamera.position : frame.c.camera.position;
        d = Domain(shade_for_camera(then, camera), ray_end(today), merge.previous);
    }
    float unhidden = luminance(direct_contribution(d.point, edge_to_light(y, d.point.position, d.previous)));
    r.point = y;
    r.target = is_free(shadow_ray_to_light(d.today, y)) ? unhidden : 0.0;
    return r;
}

/// Sum of the weights of a point over all who could hold it; -1 where the centre cannot show it. The point's holder has
/// stored its target.
float weight_sum(uint holder, LightReservoir held)
{
    float sum = 0.0;
    for (uint i = 0u; i <= merge.count; ++i) {
        LightReservoir r = i == holder ? held : held_by(i, held.point);
        float here = r.target;
        vec3 light;
        float weight = r.target > 0.0 ? mis_weight(i, r, here, light) : 0.0;
        if (i == CENTRE && here <= 0.0)
            return -1.0;
        sum += weight;
    }
    return sum;
}

/// Farthest from 1 over the points of all participants, and how many there were. Points that the centre cannot show
/// take no part.
vec2 probe()
{
    vec2 result = vec2(0.0);
    for (uint i = 0u; i <= merge.count; ++i) {
        LightReservoir r = merge.own;
        if (i != CENTRE)
            r = merge.reservoirs.at[pixel_of(i)];
        float sum = r.ucw > 0.0 ? weight_sum(i, r) : -1.0;
        if (sum >= 0.0) {
            result.x = max(result.x, abs(sum - 1.0));
            result.y += 1.0;
        }
    }
    return result;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    vec2 sums = vec2(0.0);
    if (hit.instance != INVALID_INDEX) {
        RandomKey key = direct_key(at);
        begin_merge(load_domain(hit, false), LightReservoirArray(params.source).at[pixel]);
        merge.previous = params.round == 0u;
        merge.surfaces = merge.previous ? params.previousSurface : params.surface;
        merge.reservoirs = LightReservoirArray(merge.previous ? params.history : params.source);
        merge.pairwise = params.pairwise != 0u;
        if (!merge.previous)
            add_around(key, at);
        else if (frame.c.reset == 0u)
            add_previous(key, at, hit, Vec2Image(params.motion).at[pixel]);
        if (merge.count > 0u)
            sums = probe();
    }
    Vec2Image(params.radiance).at[pixel] = sums;
}
