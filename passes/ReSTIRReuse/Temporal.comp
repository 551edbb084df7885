// Merges each pixel's candidate with the reservoir of the pixel that showed the same surface in the frame before, by the balance
// heuristic over the two domains [shaders/README: MIS weights].
#version 460
#include "prelude.glsl"
#include "merge.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ReuseParameters params; };

/// The previous pixel, when there is one that shows a similar surface.
bool find_history(uvec2 at, Hit hit, out uint pixel)
{
    vec2 u = random2(reuse_key(at), TEMPORAL_ROUND, 0u);
    if (!find_previous_pixel(at, Vec2Array(params.motion).at[gl_GlobalInvocationID.y * frame.c.size.x + at.x], u, pixel))
        return false;
    Hit before = HitArray(params.previousSurface).at[pixel];
    return before.instance != INVALID_INDEX &&
           is_similar(load_surface(hit, true), load_surface(before, true), frame.c.previousCamera.position, params.normalThreshold,
                      params.depthThreshold);
}

/// Owners of a merged path.
const uint OWN = 0u;
const uint HISTORY = 1u;

Choice merge_history(uvec2 at, Hit hit, PathReservoir own, uint before)
{
    Choice kept = Choice(own, 0.0, OWN);
    PathReservoir history = PathReservoirArray(params.history).at[before];
    float uncapped = history.confidence;
    history.confidence = min(history.confidence, params.cap * own.confidence);
    if (RESTIRPG_FAULT == REUSE_FAULT_CONFIDENCE && history.ucw <= 0.0)
        return kept;
    ShadingPoint here = load_domain(hit, false);
    ShadingPoint there = load_domain(HitArray(params.previousSurface).at[before], true);

    if (own.ucw > 0.0)
        kept.sum = present_share(own, there, own.confidence, history.confidence) * luminance(own.f) * own.ucw;
    PathReservoir shifted;
    float jacobian;
    if (shift_to(history, here, shifted, jacobian)) {
        float confidence = RESTIRPG_FAULT == REUSE_FAULT_CAP ? uncapped : history.confidence;
        float share = history_share(history, shifted, jacobian, own.confidence, confidence);
        float weight = share * luminance(shifted.f) * jacobian * history.ucw;
        choose(kept, shifted, HISTORY, weight, random1(reuse_key(at), TEMPORAL_ROUND, 1u));
    }
    finish_merge(kept, own.confidence + history.confidence);
    return kept;
}

void main()
{
    frame = FrameRef(params.frame);
    uvec2 at = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(at, frame.c.size)))
        return;
    uint pixel = at.y * frame.c.size.x + at.x;
    Hit hit = HitArray(params.surface).at[pixel];
    Choice kept = Choice(PathReservoirArray(params.source).at[pixel], 0.0, OWN);
    uint before;
    if (hit.instance != INVALID_INDEX && find_history(at, hit, before))
        kept = merge_history(at, hit, kept.path, before);
    PathReservoirArray(params.reservoirs).at[pixel] = kept.path;
    write_origin(params.origins, pixel, kept.owner == OWN ? pixel : before | OF_HISTORY);
}
