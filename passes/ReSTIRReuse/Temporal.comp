// Merges each pixel's candidate with the reservoir of the pixel that showed the same surface in the frame before, by the balance
// heuristic over the two domains [shaders/README: MIS weights].
#version 460
#include "prelude.glsl"
#include "push.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

Choice merge_history(uvec2 at, Hit hit, PathReservoir own, uint before)
{
    Choice kept = begin_merge(own);
    PathReservoir history = PathReservoirArray(params.history).at[before];
    history.confidence = min(history.confidence, params.cap * own.confidence);
    // Two shifts: this frame's path to the history's domain, and the history's path here. One place calls the shift, for compilers copy
    // its code to each.
    [[dont_unroll]] for (uint i = 0u; i < 2u; ++i) {
        bool present = i == 0u;
        PathReservoir y = history;
        Hit domain = hit;
        if (present) {
            y = own;
            domain = primary_hit(params.previousSurface, before);
        }
        PathReservoir shifted;
        float jacobian;
        bool has_image = shift_to(y, domain_today(domain, present), shifted, jacobian);
        float target = has_image ? luminance(shifted.f) * jacobian : 0.0;
        if (present && own.ucw > 0.0) {
            float share = present_share(own, target, own.confidence, history.confidence);
            choose(kept, own, share * luminance(own.f) * own.ucw, 0.0);
        } else if (!present && has_image) {
            float share = history_share(history, shifted, jacobian, own.confidence, history.confidence);
            choose(kept, shifted, share * target * history.ucw, random1(reuse_key(at), TEMPORAL_ROUND, 1u));
        }
    }
    finish_merge(kept, own.confidence + history.confidence);
    return kept;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    Choice kept = keep(PathReservoirArray(params.source).at[pixel]);
    vec2 u = random2(reuse_key(at), TEMPORAL_ROUND, 0u);
    uint before;
    // Which vertices reconnect depends on the radius of the scene's sphere: where that has changed, this frame's paths have images in the
    // history's domain that the history's paths of the same kind do not have here.
    if (hit.instance != INVALID_INDEX && frame.c.rescaled == 0u &&
        find_history(params.previousSurface, hit, at, Vec2Image(params.motion).at[pixel], u, params.rules, before))
        kept = merge_history(at, hit, kept.path, before);
    write_choice(params, pixel, kept);
}
