// The vertices of paths, as guides are trained on them. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_PATH_VERTEX_TYPES_H
#define RESTIRPG_PATH_VERTEX_TYPES_H
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

/// A smooth bounce of a path: where, and in which direction it leaves. All zero: no bounce, or a sharp one. In the
/// arrays of a pass, bounce u >= 1 of pixel (or path tree) p is number p * n + u - 1, of n that there are of each. 16
/// bytes (Zeng et al. 2025: 52).
struct PathVertex {
    /// 20 bits a coordinate in the cube of POSITION_EXTENT radii about the scene's center, x in the lowest bits; then,
    /// in the second word, the face (VERTEX_FACE_*) and VERTEX_VALID
    uvec2 position;
    uint direction;  ///< packed, see pack_direction
    uint surface;  ///< material (16 bits), VERTEX_* flags, VERTEX_DENSITY_*, VERTEX_SCATTER_*
};

/// Side of that cube, in radii of the scene: what moves may leave the sphere.
RESTIRPG_CONST POSITION_EXTENT = 4u;
RESTIRPG_CONST POSITION_BITS = 20u;

RESTIRPG_CONST VERTEX_MATERIAL_MASK = 0xffffu;
RESTIRPG_CONST VERTEX_FACE_SHIFT = 28u;  ///< 3 bits: the main axis of the geometric normal on wo's side, and its sign
RESTIRPG_CONST VERTEX_VALID = 1u << 31u;
RESTIRPG_CONST VERTEX_FINAL = 1u << 16u;  ///< the edge ends on the light
RESTIRPG_CONST VERTEX_LIGHT_SAMPLED = 1u << 17u;  ///< ... and next event estimation made it
/// The BSDF's density of the direction within the smooth label, 1/sr, see pack_logarithm
RESTIRPG_CONST VERTEX_DENSITY_SHIFT = 18u;
RESTIRPG_CONST VERTEX_SCATTER_SHIFT = 25u;  ///< luminance of f |cos|, likewise
RESTIRPG_CONST VERTEX_LOGARITHM_BITS = 7u;

/// One bounce of a raw path tree, with what came back along it. `weight` makes it a sample of the incident radiance. 24
/// bytes.
struct GuidingSample {
    PathVertex vertex;
    /// Luminance of the estimate of the incident radiance, over the density of the direction; 0: no light came
    float weight;
    float distance;  ///< m, to the next vertex; INFINITE_DISTANCE: the path escaped
};

RESTIRPG_SHARED_END
#endif
