// The guiding grid: a hash table from places to mixtures of directions. Shared by C++ and GLSL: see types.h.
//
// Two buffers have this form, each a GuidingHeader, then `capacity` keys (64 bits, 0: empty slot), then one record a
// slot: statistics (GuidingSums, then GuidingDistanceSums) as GuidingSplat adds them up in a frame, and the guide
// (GuidingCell, then GuidingMemory) that GuidingFit makes of them. Each frame has fresh ones: nothing is ever mutated
// in place [shaders/README: The guiding grid].
#ifndef RESTIRPG_GUIDING_GRID_TYPES_H
#define RESTIRPG_GUIDING_GRID_TYPES_H
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

/// Lobes of a cell's mixture, as many as a VmfMixture has (Zeng et al. 2025: 4).
RESTIRPG_CONST GUIDING_LOBES = 4u;
/// Slots tried for a key, from its own on.
RESTIRPG_CONST GUIDING_PROBES = 32u;
/// Fractional bits of the sums: integers, so that the order of the atomics does not matter [shaders/README: Fixed
/// point].
RESTIRPG_CONST GUIDING_FRACTION_BITS = 22u;
/// Most that one sample weighs: 2^19 of them fit into a sum.
RESTIRPG_CONST GUIDING_LARGEST_WEIGHT = 1u << 22u;

// A key, from its lowest bits on: three indices, the level (5 bits), the face (3) and the material (16). Its top bit is
// set, so that no key is 0.
RESTIRPG_CONST GUIDING_INDEX_BITS = 13u;
RESTIRPG_CONST GUIDING_LEVEL_SHIFT = 39u;
RESTIRPG_CONST GUIDING_FACE_SHIFT = 44u;
RESTIRPG_CONST GUIDING_MATERIAL_SHIFT = 47u;

/// What keys are made from. A cell's side is `smallest` times the largest power of two that keeps it at or below
/// `scale` times its distance from the camera, and at least `smallest`.
struct GuidingGrid {
    vec3 camera;  ///< of the frame in which the samples were splatted
    float scale;
    vec3 origin;  ///< lower corner of the space that the grid covers
    float smallest;  ///< m
};

RESTIRPG_CONST GUIDING_COSINE = 1u;  ///< lobes are multiplied by the cosine at lookup
RESTIRPG_CONST GUIDING_PARALLAX = 2u;  ///< lobes point at distances: they are re-aimed at lookup
RESTIRPG_CONST GUIDING_ALPHA = 4u;  ///< the BSDF is a component of the mixture, whose weight alpha each cell learns

struct GuidingHeader {
    GuidingGrid grid;
    uint capacity;  ///< slots, a power of two
    uint options;  ///< GUIDING_* flags; of statistics: those of the guide that they were taken against
    // Counts of the frame, for reports.
    uint cells;  ///< occupied slots
    uint collisions;  ///< slots found taken by another key while inserting
    uint failed;  ///< samples, and cells to be carried on, that found no slot
    uint samples;
    uint fitted;  ///< cells fitted in this frame
    uint guiding;  ///< cells that guide
};

/// Sums over the samples of a cell in a frame, fixed point: of responsibilities times direction and of
/// responsibilities, a lobe.
struct GuidingSums {
    Address lanes[16];  ///< lobe k: x, y, z, 1 from 4 k on
    /// The sample that the mixture explains worst: how badly (upper half), and its packed direction
    Address strangest;
    Address bsdf;  ///< of the BSDF's responsibilities, with GUIDING_ALPHA
    uint count;  ///< samples
};

/// How far the samples look, for parallax: of lobe k's responsibilities times inverse distance, 1/m.
struct GuidingDistanceSums {
    Address lanes[4];
};

/// 12 bytes.
struct GuidingLobe {
    uint direction;  ///< mean direction, packed
    float kappa;
    float weight;
};

/// 56 bytes; with its key 64 (Zeng et al. 2025: 152 with statistics).
struct GuidingCell {
    GuidingLobe lobes[4];
    uint state;  ///< frames since it was last fitted (16 bits), alpha in 65535ths
    float samples;  ///< that it was last fitted to; 0: never
};

/// What a cell remembers of earlier frames, when it does: decayed sums as in GuidingSums, in samples.
struct GuidingMemory {
    float sums[16];
    float bsdf;
    float count;
    float inverseDistances[4];  ///< as GuidingDistanceSums
};

// Bytes of the buffers' parts.
RESTIRPG_CONST GUIDING_HEADER_BYTES = 80u;
RESTIRPG_CONST GUIDING_KEY_BYTES = 8u;
RESTIRPG_CONST GUIDING_SUMS_BYTES = 152u;
RESTIRPG_CONST GUIDING_DISTANCE_SUMS_BYTES = 32u;
RESTIRPG_CONST GUIDING_CELL_BYTES = 56u;
RESTIRPG_CONST GUIDING_MEMORY_BYTES = 88u;

#ifdef __cplusplus
static_assert(GUIDING_LEVEL_SHIFT == 3 * GUIDING_INDEX_BITS && GUIDING_FACE_SHIFT == GUIDING_LEVEL_SHIFT + 5 &&
              GUIDING_MATERIAL_SHIFT == GUIDING_FACE_SHIFT + 3);
static_assert(sizeof(GuidingHeader) <= GUIDING_HEADER_BYTES && sizeof(GuidingSums) == GUIDING_SUMS_BYTES &&
              sizeof(GuidingDistanceSums) == GUIDING_DISTANCE_SUMS_BYTES && sizeof(GuidingCell) == GUIDING_CELL_BYTES &&
              sizeof(GuidingMemory) == GUIDING_MEMORY_BYTES);
#endif

RESTIRPG_SHARED_END
#endif
