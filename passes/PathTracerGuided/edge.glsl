// Where a path begins, and where its edges arrive.
#ifndef RESTIRPG_PATH_TRACER_EDGE_GLSL
#define RESTIRPG_PATH_TRACER_EDGE_GLSL

#include "push.glsl"
#include "vertex.glsl"
#include "scene/lights.glsl"
#include "trace/trace.glsl"
#include "bsdf/transmittance.glsl"

/// x_1, seen from the camera.
Vertex primary_vertex(Hit hit, uvec2 pixel)
{
    Surface surface = load_surface(hit, false);
    return make_vertex(surface, normalize(frame.c.camera.position - surface.position), pixel, 1u, params.guide, params.alpha);
}

/// The end of an edge that leaves x_u.
struct Arrival {
    bool found;  ///< a surface: x_{u+1}; else the path has left the scene
    Hit hit;
    Vertex vertex;
    float distance;  ///< m; INFINITE_DISTANCE: the path has left the scene
    vec3 absorption;  ///< along the edge
    vec3 emission;  ///< radiance that enters the edge at its end
};

/// Follow the path that leaves x_u, `from`, in direction wi.
Arrival follow(Vertex from, vec3 wi, uvec2 pixel, uint u)
{
    Arrival a;
    a.found = trace_closest(leave_surface(ray_end(from.point), wi), wi, RAY_INFINITY, a.hit, a.distance);
    if (a.found) {
        Address guide = u < params.guidedBounces ? params.guide : 0ul;
        a.vertex = make_vertex(load_surface(a.hit, false), -wi, pixel, u + 1u, guide, params.alpha);
        a.absorption = transmittance_between(from.point, wi, a.distance, a.vertex.point);
        a.emission = triangle_emission(a.hit.instance, a.hit.triangle, a.hit.barycentrics, a.vertex.point.front);
    } else {
        a.distance = INFINITE_DISTANCE;
        a.absorption = transmittance_leaving(from.point, wi, a.distance);
        a.emission = environment_radiance(wi);
    }
    return a;
}

#endif
