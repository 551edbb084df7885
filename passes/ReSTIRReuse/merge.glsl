// What temporal and spatial reuse share: domains, shifted targets, and the choice between a pixel's own path and a shifted one.
#ifndef RESTIRPG_RESTIR_REUSE_MERGE_GLSL
#define RESTIRPG_RESTIR_REUSE_MERGE_GLSL

#include "Shared.h"

#include "restir/resampling.glsl"
#include "rounds.glsl"
#include "restir/path_shift.glsl"

RandomKey reuse_key(uvec2 at)
{
    return random_key(picture_pixel(at), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_REUSE);
}

/// A primary hit shaded for the camera of its frame. The surface stands where it stands today, as all that the shifts trace does: where
/// it stood before may be inside of what has moved, from where no path leads anywhere, so that the history's light would be counted again
/// with every frame.
ShadingPoint domain_today(Hit hit, bool previous)
{
    Surface s = load_surface(hit, false);
    vec3 camera = previous ? frame.c.previousCamera.position : frame.c.camera.position;
    return shade_for_camera(s, camera);
}

/// The shift of a path that a reservoir holds: an empty one has no image anywhere.
bool shift_to(PathReservoir source, ShadingPoint x1, out PathReservoir shifted, out float jacobian)
{
    return source.ucw > 0.0 && shift_path(source, x1, shifted, jacobian);
}

// The MIS weights, of paths that a pixel holds: their target is that of the path's own f. `there` is p^_{<-j}(y) |dT/dy|: the target of
// the image in another domain, in the path's own measure; 0 where it has none. [shaders/README: MIS weights]

/// Temporal reuse, balance heuristic: the share of this frame's path y against the history.
float present_share(PathReservoir y, float there, float confidence, float history_confidence)
{
    float share = confidence * luminance(y.f);
    return share / (share + history_confidence * there);
}

/// The share of the history's path y against this pixel, which sees it as `image`.
float history_share(PathReservoir y, PathReservoir image, float jacobian, float confidence, float history_confidence)
{
    float share = history_confidence * luminance(y.f) / jacobian;
    return share / (share + confidence * luminance(image.f));
}

/// The share of a neighbour's path y against the centre, which sees it as `image`.
float neighbour_share(PathReservoir y, PathReservoir image, float jacobian, float centre_confidence, float neighbours_confidence)
{
    return pairwise_share(neighbours_confidence, luminance(y.f) / jacobian, centre_confidence, luminance(image.f));
}

/// What a neighbour leaves to the centre of the centre's path y.
float share_left(PathReservoir y, float there, float centre_confidence, float neighbours_confidence)
{
    return 1.0 - pairwise_share(neighbours_confidence, there, centre_confidence, luminance(y.f));
}

/// The path that a merge has kept so far, and the light of all that it has seen.
struct Choice {
    PathReservoir path;
    float sum;  ///< of resampling weights
    vec3 light;  ///< sum of MIS weight, f and contribution weight of each path, W/sr/m^2; its luminance is `sum`
};

/// A pixel's path that has not been merged with any.
Choice keep(PathReservoir path)
{
    return Choice(path, 0.0, path.f * path.ucw);
}

/// The start of a merge. `own` is kept until a path is chosen.
Choice begin_merge(PathReservoir own)
{
    return Choice(own, 0.0, vec3(0.0));
}

/// Take the path with this resampling weight instead of the kept one, or not.
void choose(inout Choice kept, PathReservoir path, float weight, float u)
{
    if (!(weight > 0.0) || isinf(weight))
        return;
    kept.light += path.f * (weight / luminance(path.f));
    if (resample(kept.sum, weight, u))
        kept.path = path;
}

/// Close a merge: the kept path's contribution weight, and all participants' confidence.
void finish_merge(inout Choice kept, float confidence)
{
    float target = luminance(kept.path.f);
    kept.path.ucw = kept.sum > 0.0 && target > 0.0 ? kept.sum / target : 0.0;
    kept.path.confidence = confidence;
}

/// Write what a merge has left in a pixel.
void write_choice(ReuseParameters params, uint pixel, Choice kept)
{
    PathReservoirArray(params.reservoirs).at[pixel] = kept.path;
    if (params.radiance != 0ul)
        Vec3Image(params.radiance).at[pixel] = kept.light;
}

#endif
