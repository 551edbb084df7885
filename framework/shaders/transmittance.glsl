// Absorption inside solids (KHR_materials_volume), by Beer and Lambert's law.
#ifndef RESTIRPG_TRANSMITTANCE_GLSL
#define RESTIRPG_TRANSMITTANCE_GLSL

#include "surface.glsl"

/// Along a segment of `distance` metres that leaves p in the world direction wi.
vec3 transmittance_leaving(ShadingPoint p, vec3 wi, float distance)
{
    bool inwards = (dot(p.normal, wi) > 0.0) != p.front;
    return inwards && p.absorption != vec3(0.0) ? exp(-p.absorption * distance) : vec3(1.0);
}

#endif
