// What temporal and spatial reuse share: domains, shifted targets, and the choice between a pixel's own path and a shifted one.
#ifndef RESTIRPG_RESTIR_REUSE_MERGE_GLSL
#define RESTIRPG_RESTIR_REUSE_MERGE_GLSL

#include "Shared.h"
#include "neighbours.glsl"
#include "path_shift.glsl"

#ifndef RESTIRPG_FAULT
#define RESTIRPG_FAULT REUSE_FAULT_NONE
#endif

layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer Vec2Array { vec2 at[]; };

/// XORed into the seed: no number of this pass is one of another pass.
const uint RANDOM_STREAM_REUSE = 0x51ed270bu;
/// "Bounces" of this pass's random numbers: a round of spatial reuse, or temporal reuse.
const uint TEMPORAL_ROUND = 0xffffu;

RandomKey reuse_key(uvec2 at)
{
    return random_key(at, frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE);
}

/// A primary hit shaded for the camera of its frame.
ShadingPoint load_domain(Hit hit, bool previous)
{
    Surface s = load_surface(hit, previous);
    bool before = previous && RESTIRPG_FAULT != REUSE_FAULT_PREVIOUS_CAMERA;
    vec3 camera = before ? frame.c.previousCamera.position : frame.c.camera.position;
    return shade_surface(s, normalize(camera - s.position));
}

/// Shift for reuse; with the fault, without its Jacobian.
bool shift_to(PathReservoir source, ShadingPoint x1, out PathReservoir shifted, out float jacobian)
{
    bool shiftable = source.ucw > 0.0 && shift_path(source, x1, shifted, jacobian);
    if (RESTIRPG_FAULT == REUSE_FAULT_JACOBIAN)
        jacobian = 1.0;
    return shiftable;
}

/// p^_{<-j}(y) |dT/dy|: the target of y's image in another domain, in y's own measure; 0 where it has none.
float target_in(PathReservoir y, ShadingPoint x1)
{
    PathReservoir shifted;
    float jacobian;
    return shift_to(y, x1, shifted, jacobian) ? luminance(shifted.f) * jacobian : 0.0;
}

/// The path that a merge has kept so far, and whose it was.
struct Choice {
    PathReservoir path;
    float sum;  ///< of resampling weights
    uint owner;
};

/// Take the path with this resampling weight instead of the kept one, or not.
void choose(inout Choice kept, PathReservoir path, uint owner, float weight, float u)
{
    if (!(weight > 0.0) || isinf(weight))
        return;
    kept.sum += weight;
    if (u * kept.sum < weight) {
        kept.path = path;
        kept.owner = owner;
    }
}

/// Close a merge: the kept path's contribution weight, and all participants' confidence.
void finish_merge(inout Choice kept, float confidence)
{
    float target = luminance(kept.path.f);
    kept.path.ucw = kept.sum > 0.0 && target > 0.0 ? kept.sum / target : 0.0;
    kept.path.confidence = confidence;
}

/// The kept path's vertices go with it. Those before its reconnection are still the owner's: Vertices.comp replaces them.
void copy_vertices(Address from, uint owner, Address to, uint pixel, uint stride)
{
    if (to == 0ul)
        return;
    for (uint i = 0u; i < stride; ++i)
        PathVertexArray(to).at[pixel * stride + i] = PathVertexArray(from).at[owner * stride + i];
}

#endif
