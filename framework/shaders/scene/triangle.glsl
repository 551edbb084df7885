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

/// A triangle of a placed mesh in a pose of it: that of this frame, or of the one before.
WorldTriangle place_triangle(Instance placed, Corners corners, mat4x3 pose)
{
    vec3 p0 = corners.a.position;
    // Edges in object space first: a small triangle far from the origin keeps its shape.
    vec3 edge1 = corners.b.position - p0;
    vec3 edge2 = corners.c.position - p0;
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
    return place_triangle(placed, load_corners(load_triangle(placed, triangle).vertices), pose);
}

/// The matrix over its largest entry, so that products of three entries stay finite at any scale of a scene.
mat3 of_unit_size(mat3 m)
{
    vec3 largest = max(abs(m[0]), max(abs(m[1]), abs(m[2])));
    return m * (1.0 / max(largest.x, max(largest.y, largest.z)));
}

/// The inverse transpose times the determinant: what normals transform by, but for length and sign.
mat3 cofactors(mat3 m)
{
    return mat3(cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1]));
}

/// dot(abs(n * m), abs(inverse(m)) * v): how far along n a point moves that inverse(m) has taken to another space, where it moves as far as
/// v reaches.
float span_along(mat3 m, vec3 n, vec3 v)
{
    m = of_unit_size(m);
    mat3 c = cofactors(m);
    vec3 inverse_v = vec3(dot(abs(c[0]), v), dot(abs(c[1]), v), dot(abs(c[2]), v));
    return dot(abs(n * m), inverse_v) / max(abs(dot(m[0], c[0])), 1e-30);
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
/// - the triangle test finds the height of the ray's origin over the triangle, the scalar triple product of its edges and the way to its
///   first corner, over its cross product: 7 times the product of the three lengths, over twice the area. It is least where the first
///   corner is opposite the longest edge, as the reader turns triangles (startAtWidestCorners of scene.h): close to 7 times the second longest
///   edge. From the sharp corner of a long thin one it would be as many times more as the triangle is longer than wide.
float find_clearance(WorldTriangle t, Instance placed, vec3 x, vec3 n)
{
    mat4x3 pose = placed.objectToWorld;
#if RESTIRPG_RAY_QUERY
    // The driver moves the ray with an inverse of its own, whose translation is not small where the object is far from the origin.
    vec3 moved = 16.0 * (abs(x) + abs(pose[3]));
#else
    vec3 moved = 5.0 * abs(x - pose[3]);
#endif
    float placing = dot(abs(n), 4.0 * abs(x) + t.rounding) + span_along(mat3(pose), n, moved);
    float length1 = length(t.edge1);
    float length2 = length(t.edge2);
    float testing = 7.0 * max(length1, length2) * length1 * length2 / length(t.cross_product);
    return UNIT_ROUNDOFF * (placing + testing);
}

#endif
