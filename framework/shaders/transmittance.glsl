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

/// Along a segment between two surfaces: inside the solid that it leaves into, else inside the one that it arrives from.
vec3 transmittance_between(ShadingPoint from, vec3 wi, float distance, ShadingPoint to)
{
    bool inwards = (dot(from.normal, wi) > 0.0) != from.front;
    if (inwards && from.absorption != vec3(0.0))
        return exp(-from.absorption * distance);
    return !to.front && to.absorption != vec3(0.0) ? exp(-to.absorption * distance) : vec3(1.0);
}

#endif
