// The reservoir of ReSTIR DI. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_LIGHT_RESERVOIR_TYPES_H
#define RESTIRPG_LIGHT_RESERVOIR_TYPES_H
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

/// A point of a light, stored so that it follows the light when it moves:
///   triangle      the triangle and the point's barycentrics (measure: the unit triangle of barycentrics)
///   environment   octahedral direction (measure: solid angle)
///   punctual      index into the light table (counting measure)
struct LightPoint {
    uint instance;  ///< INVALID_INDEX: `index` is a light of the table; else a triangle of this instance
    uint index;  ///< triangle within the mesh, or light
    vec2 place;  ///< barycentrics, or octahedral direction
};

/// One light point chosen by resampling, as the pixel sees it. All zero: empty. 28 bytes.
struct LightReservoir {
    LightPoint point;
    float ucw;  ///< unbiased contribution weight W: about 1 / density in the point's measure; 0: no light
    float confidence;  ///< M: how many candidate sets stand behind it
    float target;  ///< luminance of the light that the point sends to the camera by way of this pixel's surface; lit
};

RESTIRPG_SHARED_END
#endif
