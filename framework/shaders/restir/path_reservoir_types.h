// The reservoir of ReSTIR PT. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_PATH_RESERVOIR_TYPES_H
#define RESTIRPG_PATH_RESERVOIR_TYPES_H
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

/// One path x_0 (camera), x_1 (primary hit), ..., x_D (light) chosen by resampling, as its pixel sees it
/// [shaders/README: The shift and its Jacobian]. k is the index of the reconnection vertex: 2 <= k < D a surface, k = D
/// the light point, k = 0 none (the last bounce is a delta). Bounces 1 ... k - 2 (k = 0: all) are replayed when the
/// path is shifted. All zero: empty. 88 bytes.
struct PathReservoir {
    /// Light the path sends to the camera, per product of solid angles; of rough sharp bounces before the last per
    /// random numbers (counting measure: delta lobes, punctual lights) [shaders/README: Measures]
    vec3 f;
    float ucw;  ///< unbiased contribution weight W; 0: carries no light
    float confidence;  ///< M: how many pixels' candidates stand behind it
    uint shape;  ///< D | k << 8 | PATH_LIGHT_SAMPLED | bounce u is a delta: 1 << (15 + u)
    uint labels;  ///< LABEL_* of bounce u in bits 2u - 2 and 2u - 1
    uint pixel;  ///< key of the candidate's random numbers, with `frame`: replays sharp bounces
    uint frame;  ///< with the tree's number, see tree_key
    uvec4 prefix;  ///< packed directions of the first smooth bounces, world space; beyond x_k for guides alone
    uvec2 anchor;  ///< 0 < k < D: instance and triangle of x_k; else LightPoint's instance and index
    vec2 place;  ///< barycentrics of x_k; else LightPoint::place
    uint direction;  ///< 0 < k < D: packed direction in which the path leaves x_k
    /// d(solid angle at x_{k-1}) / d(measure of x_k), up to a constant: |cos| / d^2; 1: environment, punctual
    float geometry;
    vec3 suffix;  ///< 0 < k < D: what lies beyond the bounce at x_k, as in f: bounces, absorption, light
};

/// Smooth bounces whose direction is kept; a path that would have to replay a later one cannot be shifted
/// [shaders/README: What may reconnect].
RESTIRPG_CONST PATH_PREFIX = 4u;
/// Bounces of a path that its reservoir tells are at most so many: those of the prefix, and those at both ends of the
/// edge that reconnects [shaders/README: Learning: the splat].
RESTIRPG_CONST PATH_TOLD = PATH_PREFIX + 2u;
/// Of PathReservoir::shape: next event estimation has made the path's last edge.
RESTIRPG_CONST PATH_LIGHT_SAMPLED = 1u << 7u;
/// Longest path: labels of 16 bounces.
RESTIRPG_CONST PATH_MAX_EDGES = 17u;

RESTIRPG_SHARED_END
#endif
