// Ray tracing behind one interface. The back end is chosen when the kernel is compiled: RESTIRPG_RAY_QUERY.
//
//   bool trace_closest(vec3 origin, vec3 direction, float t_max, out Hit hit, out float t)
//   bool trace_any(vec3 origin, vec3 direction, float t_max)
//
// Rays start at t = 0: origins are moved off their surface by leave_surface. Triangles are hit from both sides. Alpha masks are
// applied when the scene has any (RESTIRPG_ALPHA_MASK).
#ifndef RESTIRPG_TRACE_GLSL
#define RESTIRPG_TRACE_GLSL

#include "scene/alpha_mask.glsl"
#include "scene/triangle.glsl"

/// Farther than any scene.
const float RAY_INFINITY = 1e30;

#if RESTIRPG_ALPHA_MASK
bool passes_alpha_mask(uint instance, uint triangle, vec2 barycentrics)
{
    return passes_alpha_mask(load_triangle(load_instance(instance), triangle), barycentrics);
}
#endif

#if RESTIRPG_RAY_QUERY
#include "trace_rayquery.glsl"
#else
#include "trace_software.glsl"
#endif

/// Where a ray starts that leaves the surface in the direction.
vec3 leave_surface(RayEnd x, vec3 direction)
{
    return x.position + (dot(x.normal, direction) > 0.0 ? x.clearance : -x.clearance) * x.normal;
}

/// A ray that must meet nothing before t_max, in units of its direction.
struct ShadowRay {
    vec3 origin;
    vec3 direction;
    float t_max;
};

/// Between two points, to the sides of their surfaces that face each other.
ShadowRay shadow_ray(RayEnd x, RayEnd y)
{
    // How much lower y's surface may seem from afar: that of the ray's rounding, and of the intersection test's.
    const float RELATIVE_ERROR = 16.0 * UNIT_ROUNDOFF;
    vec3 d = y.position - x.position;
    y.clearance += RELATIVE_ERROR * length(d);
    vec3 origin = leave_surface(x, d);
    return ShadowRay(origin, leave_surface(y, -d) - origin, 1.0);
}

/// In a direction, to infinity.
ShadowRay shadow_ray(RayEnd x, vec3 direction)
{
    return ShadowRay(leave_surface(x, direction), direction, RAY_INFINITY);
}

bool is_free(ShadowRay ray)
{
    return !trace_any(ray.origin, ray.direction, ray.t_max);
}

#endif
