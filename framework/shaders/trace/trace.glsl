// Ray tracing behind one interface. The back end is chosen when the kernel is compiled: RESTIRPG_RAY_QUERY.
//
//   bool trace_closest(vec3 origin, vec3 direction, float t_max, out Hit hit, out float t)
//   bool trace_any(vec3 origin, vec3 direction, float t_max)
//
// Rays start at t = 0: origins are moved off their surface by leave_surface. Triangles are hit from both sides. Alpha masks are
// applied when the scene has any (RESTIRPG_ALPHA_MASK).
#ifndef RESTIRPG_TRACE_GLSL
#define RESTIRPG_TRACE_GLSL

#include "scene/triangle.glsl"

/// Farther than any scene.
const float RAY_INFINITY = 1e30;

#if RESTIRPG_ALPHA_MASK
/// Is the surface there at all, at this point of it?
bool passes_alpha_mask(uint instance, uint triangle, vec2 barycentrics)
{
    MeshTriangle record = load_triangle(load_instance(instance), triangle);
    uint material_index = record.material & TRIANGLE_MATERIAL;
    if ((load_material(material_index).flags & MATERIAL_ALPHA_MASK) == 0u)
        return true;
    Material material = MaterialArray(SCENE.materials).at[material_index];
    uvec3 index = record.vertices;
    VertexExtrasArray extras = VertexExtrasArray(SCENE.vertexExtras);
    vec3 corner = vec3(extras.at[index.x].color.a, extras.at[index.y].color.a, extras.at[index.z].color.a);
    // Differences, so that equal corners give exactly their alpha: it may equal the cutoff.
    float alpha = material.alpha * (corner.x + dot(barycentrics, corner.yz - corner.x));
    TextureRef map = load_map(material_index, MAP_BASE_COLOR);
    if (map.index != INVALID_INDEX) {
        vec3 weight = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
        Corners corners = load_corners(index);
        vec2 uv0 = mat3x2(corners.a.uv0, corners.b.uv0, corners.c.uv0) * weight;
        vec2 uv1 = mat3x2(extras.at[index.x].uv1, extras.at[index.y].uv1, extras.at[index.z].uv1) * weight;
        alpha *= fetch_texture(map, uv0, uv1).a;
    }
    return alpha >= material.alphaCutoff;
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
