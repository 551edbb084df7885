// Ray tracing behind one interface. The back end is chosen when the kernel is compiled: RESTIRPG_RAY_QUERY.
//
//   bool trace_closest(vec3 origin, vec3 direction, float t_max, out Hit hit, out float t)
//   bool trace_any(vec3 origin, vec3 direction, float t_max)
//
// Rays start at t = 0: origins are moved off their surface by offset_origin. Triangles are hit from both sides. Alpha masks are
// applied when the scene has any (RESTIRPG_ALPHA_MASK).
#ifndef RESTIRPG_TRACE_GLSL
#define RESTIRPG_TRACE_GLSL

#include "scene.glsl"

/// Farther than any scene.
const float RAY_INFINITY = 1e30;

#if RESTIRPG_ALPHA_MASK
/// Is the surface there at all, at this point of it?
bool passes_alpha_mask(uint instance, uint triangle, vec2 barycentrics)
{
    Mesh mesh = MeshArray(SCENE.meshes).at[InstanceArray(SCENE.instances).at[instance].mesh];
    Material material = MaterialArray(SCENE.materials).at[UintArray(SCENE.materialOfTriangle).at[mesh.firstTriangle + triangle]];
    if ((material.flags & MATERIAL_ALPHA_MASK) == 0u)
        return true;
    uvec3 index = Uvec3Array(SCENE.indices).at[mesh.firstTriangle + triangle] + mesh.firstVertex;
    AttributesArray attributes = AttributesArray(SCENE.attributes);
    vec3 corner = vec3(attributes.at[index.x].color.a, attributes.at[index.y].color.a, attributes.at[index.z].color.a);
    // Differences, so that equal corners give exactly their alpha: it may equal the cutoff.
    float alpha = material.alpha * (corner.x + dot(barycentrics, corner.yz - corner.x));
    if (material.baseColorMap.index != INVALID_INDEX) {
        vec3 weight = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
        vec2 uv0 = mat3x2(attributes.at[index.x].uv0, attributes.at[index.y].uv0, attributes.at[index.z].uv0) * weight;
        vec2 uv1 = mat3x2(attributes.at[index.x].uv1, attributes.at[index.y].uv1, attributes.at[index.z].uv1) * weight;
        alpha *= fetch_texture(material.baseColorMap, uv0, uv1).a;
    }
    return alpha >= material.alphaCutoff;
}
#endif

#if RESTIRPG_RAY_QUERY
#include "trace_rayquery.glsl"
#else
#include "trace_software.glsl"
#endif

/// A point moved off its surface along the unit normal n (towards the side the ray leaves on), by a few units in the last place
/// of its coordinates. Waechter & Binder 2019, "A Fast and Robust Method for Avoiding Self-Intersection".
vec3 offset_origin(vec3 p, vec3 n)
{
    const float NEAR_ORIGIN = 1.0 / 32.0;
    const float FLOAT_STEP = 1.0 / 65536.0;
    const float INT_STEP = 256.0;
    ivec3 step = ivec3(INT_STEP * n);
    vec3 stepped = intBitsToFloat(floatBitsToInt(p) + ivec3(p.x < 0.0 ? -step.x : step.x, p.y < 0.0 ? -step.y : step.y,
                                                            p.z < 0.0 ? -step.z : step.z));
    return mix(stepped, p + FLOAT_STEP * n, lessThan(abs(p), vec3(NEAR_ORIGIN)));
}

/// A ray that must meet nothing before t_max, in units of its direction.
struct ShadowRay {
    vec3 origin;
    vec3 direction;
    float t_max;
};

/// Between the surface points x and y. Both are moved off their surfaces: nx and ny point to the sides that face each other.
ShadowRay shadow_ray(vec3 x, vec3 nx, vec3 y, vec3 ny)
{
    vec3 origin = offset_origin(x, nx);
    return ShadowRay(origin, offset_origin(y, ny) - origin, 1.0);
}

bool is_free(ShadowRay ray)
{
    return !trace_any(ray.origin, ray.direction, ray.t_max);
}

/// Is y seen from x? See shadow_ray.
bool visible(vec3 x, vec3 nx, vec3 y, vec3 ny)
{
    return is_free(shadow_ray(x, nx, y, ny));
}

#endif
