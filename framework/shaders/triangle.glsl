// A triangle of a placed mesh in world space, and how far off it rays have to start.
#ifndef RESTIRPG_TRIANGLE_GLSL
#define RESTIRPG_TRIANGLE_GLSL

#include "scene.glsl"

/// Half the distance between 1 and the next float: the largest relative error of a rounded operation.
const float UNIT_ROUNDOFF = 5.9604645e-8;

/// A triangle in world space. `cross_product` is twice the area long and points to the front.
struct WorldTriangle {
    vec3 p0;
    vec3 edge1;
    vec3 edge2;
    vec3 cross_product;
    vec3 rounding;  ///< how large the terms were that p0 and the edges were summed from, per axis
};

/// A point of a surface as the end of a ray.
struct RayEnd {
    vec3 position;
    vec3 normal;  ///< unit, geometric
    float clearance;  ///< rays start and end this far off the surface, along the normal, to either side
};

/// The vertices of a triangle, in the scene's arrays.
uvec3 vertices_of(Mesh mesh, uint triangle)
{
    return Uvec3Array(SCENE.indices).at[mesh.firstTriangle + triangle] + mesh.firstVertex;
}

/// The triangle of a placed mesh in the given pose: that of this frame, or the previous one.
WorldTriangle place_triangle(Instance placed, uvec3 index, mat4x3 pose)
{
    Vec3Array positions = Vec3Array(SCENE.positions);
    vec3 p0 = positions.at[index.x];
    // Edges in object space first: a small triangle far from the origin keeps its shape.
    vec3 edge1 = positions.at[index.y] - p0;
    vec3 edge2 = positions.at[index.z] - p0;
    mat3 linear = mat3(pose);
    WorldTriangle t;
    // The translation last: it is often by far the largest term, and is rounded but once.
    t.p0 = linear * p0 + pose[3];
    t.edge1 = linear * edge1;
    t.edge2 = linear * edge2;
    t.cross_product = cross(t.edge1, t.edge2) * (placed.flipped != 0u ? -1.0 : 1.0);
    t.rounding = mat3(abs(linear[0]), abs(linear[1]), abs(linear[2])) * (3.0 * abs(p0) + 8.0 * (abs(edge1) + abs(edge2)));
    return t;
}

WorldTriangle place_triangle(Instance placed, uint triangle, mat4x3 pose)
{
    return place_triangle(placed, vertices_of(MeshArray(SCENE.meshes).at[placed.mesh], triangle), pose);
}

vec3 point_on(WorldTriangle t, vec2 barycentrics)
{
    return t.p0 + (barycentrics.x * t.edge1 + barycentrics.y * t.edge2);
}

/// A bound of how far traversal can see the triangle from its point x, as point_on gives it in the instance's pose of this frame, along
/// the unit normal n. To first order in the unit roundoff [Higham 2002, chapter 3; Pharr et al. 2023, section 6.8], summed:
///
/// - x, the traversal's corners and the origin of the ray are rounded to the world's floats: 4 |x|;
/// - x is summed from the corner and the edges, and the traversal's edges are rounded: `rounding`;
/// - to meet an instance with a hierarchy of its own, the ray is moved to object space;
/// - Moeller and Trumbore's test finds the height of the ray's origin over the triangle, the scalar triple product of its edges and the way
///   to its first corner, over its cross product: 7 times the product of the three lengths, over twice the area.
float find_clearance(WorldTriangle t, Instance placed, vec3 x, vec3 n)
{
    mat4x3 pose = placed.objectToWorld;
    mat3 inverse_linear = mat3(placed.worldToObject);
    inverse_linear = mat3(abs(inverse_linear[0]), abs(inverse_linear[1]), abs(inverse_linear[2]));
#if RESTIRPG_RAY_QUERY
    // The driver moves the ray with an inverse of its own, whose translation is not small where the object is far from the origin.
    vec3 in_object = 16.0 * (inverse_linear * (abs(x) + abs(pose[3])));
#else
    vec3 in_object = 5.0 * (inverse_linear * abs(x - pose[3]));
#endif
    float placing = dot(abs(n), 4.0 * abs(x) + t.rounding) + dot(abs(n * mat3(pose)), in_object);
    float length1 = length(t.edge1);
    float length2 = length(t.edge2);
    float testing = 7.0 * max(length1, length2) * length1 * length2 / length(t.cross_product);
    return UNIT_ROUNDOFF * (placing + testing);
}

#endif
