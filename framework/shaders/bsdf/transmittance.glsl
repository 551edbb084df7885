// Absorption inside solids (KHR_materials_volume), by Beer and Lambert's law.
#ifndef RESTIRPG_TRANSMITTANCE_GLSL
#define RESTIRPG_TRANSMITTANCE_GLSL

#include "scene/surface.glsl"

/// Along a segment of `distance` metres that leaves p in the world direction wi: inside the solid that it leaves into, else by
/// `arrival`, the absorption on the side of the surface that it ends on.
vec3 transmittance_along(ShadingPoint p, vec3 wi, float distance, vec3 arrival)
{
    bool inwards = (dot(p.normal, wi) > 0.0) != p.front;
    vec3 absorption = inwards && p.absorption != vec3(0.0) ? p.absorption : arrival;
    return absorption != vec3(0.0) ? exp(-absorption * distance) : vec3(1.0);
}

/// Towards a light without a surface.
vec3 transmittance_leaving(ShadingPoint p, vec3 wi, float distance)
{
    return transmittance_along(p, wi, distance, vec3(0.0));
}

/// Between two surfaces.
vec3 transmittance_between(ShadingPoint from, vec3 wi, float distance, ShadingPoint to)
{
    return transmittance_along(from, wi, distance, to.front ? vec3(0.0) : to.absorption);
}

/// Between a primary hit and its camera, which may stand inside the solid.
vec3 transmittance_to_camera(ShadingPoint p, vec3 camera)
{
    vec3 d = camera - p.position;
    return transmittance_leaving(p, d, length(d));
}

/// The surface as the camera at that place sees it.
ShadingPoint shade_for_camera(Surface s, vec3 camera)
{
    ShadingPoint p = shade_surface(s, normalize(camera - s.position));
    p.to_camera = transmittance_to_camera(p, camera);
    return p;
}

#endif
