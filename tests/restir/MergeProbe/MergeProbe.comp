// The MIS weights of one point, over all who could hold it, add up to 1: whichever participant made the point.
#version 460
#include "prelude.glsl"
#include "../../../passes/ReSTIRDI/participants.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReSTIRDIParameters params; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Vec2Array { vec2 at[]; };

/// The target that the kernel of pixel j's own frame stores with a point that it holds.
float stored_target(uint j, LightPoint y)
{
    Surface today = load_surface(primary_hit(merge.surfaces, neighbour_pixel(j)), false);
    Surface then = load_surface(primary_hit(merge.surfaces, neighbour_pixel(j)), merge.previous);
    vec3 camera = merge.previous ? frame.c.previousCamera.position : frame.c.camera.position;
    ShadingPoint point = shade_surface(then, normalize(camera - then.position));
    return evaluate_target(Domain(point, ray_end(today), merge.previous), y);
}

/// Sum of the weights of the point that `holder` holds with the given target.
float weight_sum(uint holder, LightPoint y, float target, float here)
{
    float sum = centre_weight(y, here);
    for (uint j = 0u; j < merge.count; ++j) {
        float there = j == holder ? target : stored_target(j, y);
        if (there > 0.0)
            sum += neighbour_weight(j, y, there, here);
    }
    return sum;
}

/// Farthest from 1 over the points of all participants, and how many there were. Points that the centre cannot show
/// take no part.
vec2 probe()
{
    vec2 result = vec2(0.0);
    for (uint i = 0u; i <= merge.count; ++i) {
        uint holder = i < merge.count ? i : CENTRE;
        LightReservoir r = merge.own;
        if (holder != CENTRE)
            r = merge.reservoirs.at[neighbour_pixel(i)];
        float here = r.ucw <= 0.0 ? 0.0 : holder == CENTRE ? r.target : target_at_centre(r.point);
        if (here > 0.0) {
            result.x = max(result.x, abs(weight_sum(holder, r.point, r.target, here) - 1.0));
            result.y += 1.0;
        }
    }
    return result;
}

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    uint pixel = at.y * frame.c.size.x + at.x;
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
            add_around(params, key, at);
        else if (frame.c.reset == 0u)
            add_previous(params, key, at, hit, Vec2Array(params.motion).at[pixel]);
        if (merge.count > 0u)
            sums = probe();
    }
    Vec2Array(params.radiance).at[pixel] = sums;
}
