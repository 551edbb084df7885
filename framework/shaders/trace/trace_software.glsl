// The software back end: a two-level BVH2 traversed in one loop, read by device address (measured on lavapipe: 2.3 to 3.6 times
// as fast as its ray query). See trace.glsl for the interface.
#ifndef RESTIRPG_TRACE_SOFTWARE_GLSL
#define RESTIRPG_TRACE_SOFTWARE_GLSL

#include "math/stack.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BvhTriangleArray { BvhTriangle at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer BvhObjectArray { BvhObject at[]; };

/// On the stack: leave the object, go on in the world's hierarchy. No node index is as low, no leaf as high.
const int LEAVE_OBJECT = int(0x80000000);

/// 1 / d with zero components pushed away from zero, so that slab tests stay finite.
vec3 safe_reciprocal(vec3 d)
{
    const float SMALLEST = 1e-20;
    return 1.0 / mix(d, mix(vec3(-SMALLEST), vec3(SMALLEST), greaterThanEqual(d, vec3(0.0))), lessThan(abs(d), vec3(SMALLEST)));
}

/// A ray for boxes on a grid: it crosses the lower side of one, at coordinate x, at t = x * reciprocal - lower, and the upper side alike.
struct GridRay {
    vec3 reciprocal;
    vec3 lower;
    vec3 upper;
};

/// Every box is made larger by what rounding may move a point of the ray by: a part of its way from the grid's origin, along the longest
/// axis since an object's rotation mixes them.
GridRay on_grid(vec3 origin, vec3 direction, BvhGrid grid)
{
    const float ROUNDING = 8.0 * UNIT_ROUNDOFF;
    vec3 from = origin - grid.origin;
    float reach = max(abs(from.x), max(abs(from.y), abs(from.z)));
    vec3 slack = ROUNDING * (reach + grid.width) * grid.scale;
    vec3 reciprocal = safe_reciprocal(direction * grid.scale);
    vec3 at = from * grid.scale;
    return GridRay(reciprocal, (at + slack) * reciprocal, (at - slack) * reciprocal);
}

/// What enter_box gives for a box that the ray does not enter: above the bits of every finite float.
const int MISSED = 0x7f800001;

/// Where the ray enters the box, as the bits of a float, or MISSED also when it enters beyond t_max. Positive floats and their bits are in the
/// same order; negative ones are not, but it is enough that they stay below zero: whatever is behind the origin counts as 0 or as a miss.
/// On CPU devices the minimum of two integers is one instruction, that of two floats three, since either may be no number.
/// The far side is moved by two units in the last place: Ize 2013, "Robust BVH Ray Traversal".
int enter_box(uvec3 box, GridRay ray, float t_max)
{
    ivec3 t0 = floatBitsToInt(vec3(ivec3(box & 0xffffu)) * ray.reciprocal - ray.lower);
    ivec3 t1 = floatBitsToInt(vec3(ivec3(box >> 16)) * ray.reciprocal - ray.upper);
    ivec3 low = min(t0, t1);
    ivec3 high = max(t0, t1);
    int enter = max(max(low.x, low.y), max(low.z, 0));
    int leave = min(min(high.x, high.y), min(high.z, floatBitsToInt(t_max)));
    return enter <= leave + 2 ? enter : MISSED;
}

/// Both sides: barycentrics in xy, t in z. The ray has to pass all edges on one side: the signs of the volumes that it spans with each edge.
/// Two triangles that meet in an edge find the same volume there but for its sign, so that no ray passes between them. Moeller and Trumbore's
/// test (1997) rounds it differently in each: of the rays to a closed mesh, a share of 2e-7 distances per edge length passed through. The
/// form of the volumes is that of Embree's robust mode: the edge is subtracted before it is multiplied, so that small triangles far off keep
/// their digits. t is the plane's, from the edges that find_clearance counts on.
bool hit_triangle(BvhTriangle triangle, vec3 origin, vec3 direction, float t_max, out vec3 uvt)
{
    vec3 a = triangle.corner0 - origin, b = triangle.corner1 - origin, c = triangle.corner2 - origin;
    vec3 volumes = vec3(dot(cross(b - c, b + c), direction), dot(cross(c - a, c + a), direction), dot(cross(a - b, a + b), direction));
    float sum = volumes.x + volumes.y + volumes.z;
    vec3 normal = cross(triangle.corner1 - triangle.corner0, triangle.corner2 - triangle.corner0);
    uvt = vec3(volumes.yz / sum, dot(a, normal) / dot(direction, normal));
    float least = min(volumes.x, min(volumes.y, volumes.z)), most = max(volumes.x, max(volumes.y, volumes.z));
    return (least >= 0.0 || most <= 0.0) && sum != 0.0 && uvt.z > 0.0 && uvt.z < t_max;
}

BvhNode load_node(Address nodes, int index)
{
    WordArray record = record_at(nodes, uint(index), BVH_NODE_BYTES);
    uvec2 a = uints_of(record, 0u), b = uints_of(record, 1u), c = uints_of(record, 2u), children = uints_of(record, 3u);
    return BvhNode(uvec3(a, b.x), uvec3(b.y, c), int(children.x), int(children.y));
}

/// Without the index within the mesh, which shares no word with the corners.
BvhTriangle load_bvh_triangle(Address triangles, uint index)
{
    WordArray record = record_at(triangles, index, BVH_TRIANGLE_BYTES);
    vec2 a = floats_of(record, 0u), b = floats_of(record, 1u), c = floats_of(record, 2u), d = floats_of(record, 3u);
    uvec2 e = uints_of(record, 4u);
    return BvhTriangle(vec3(a, b.x), vec3(b.y, c), vec3(d, uintBitsToFloat(e.x)), e.y, 0u, 0u);
}

/// A hierarchy and the ray in its space.
struct Space {
    Address nodes;
    Address triangles;
    uint instance;  ///< INVALID_INDEX: the static batch, whose triangles name their own
    bool masked;
    vec3 origin;
    vec3 direction;
    GridRay ray;
};

Space object_space(uint index, vec3 world_origin, vec3 world_direction)
{
    BvhObject object = BvhObjectArray(SCENE.bvhObjects).at[index];
    // The last column is the object's place in the world: taken off first, objects far from the origin lose no precision.
    vec3 origin = mat3(object.worldToObject) * (world_origin - object.worldToObject[3]);
    vec3 direction = mat3(object.worldToObject) * world_direction;
    return Space(object.nodes, object.triangles, object.instance, object.masked != 0u, origin, direction,
                 on_grid(origin, direction, object.grid));
}

/// The static batch, which is in world space.
Space batch_space(vec3 origin, vec3 direction)
{
    BvhObject object = BvhObjectArray(SCENE.bvhObjects).at[0];
    return Space(object.nodes, object.triangles, INVALID_INDEX, object.masked != 0u, origin, direction,
                 on_grid(origin, direction, object.grid));
}

Space world_space(vec3 origin, vec3 direction)
{
    return Space(SCENE.tlasNodes, 0ul, INVALID_INDEX, false, origin, direction, on_grid(origin, direction, SCENE.tlasGrid));
}

/// The nearest triangle so far. Its names are read but once, at the end.
struct Found {
    Address triangles;
    uint index;  ///< INVALID_INDEX: none
    uint instance;  ///< as in Space
    vec2 barycentrics;
};

Hit name_hit(Found found)
{
    BvhTriangleArray triangles = BvhTriangleArray(found.triangles);
    uint instance = found.instance == INVALID_INDEX ? triangles.at[found.index].instance : found.instance;
    return Hit(instance, triangles.at[found.index].triangle, found.barycentrics);
}

void meet_leaf(int leaf, Space space, inout float t, inout Found found)
{
    uint first = uint(~leaf) >> BVH_LEAF_BITS;
    uint last = first + (uint(~leaf) & ((1u << BVH_LEAF_BITS) - 1u));
    uint i = first;
    do {  // not `for`: see traverse
        vec3 uvt;
        BvhTriangle triangle = load_bvh_triangle(space.triangles, i);
        bool hits = hit_triangle(triangle, space.origin, space.direction, t, uvt);
#if RESTIRPG_ALPHA_MASK
        if (hits && space.masked)
            hits = passes_alpha_mask(space.instance == INVALID_INDEX ? triangle.instance : space.instance,
                                     BvhTriangleArray(space.triangles).at[i].triangle, uvt.xy);
#endif
        if (hits) {
            t = uvt.z;
            found = Found(space.triangles, i, space.instance, uvt.xy);
        }
    } while (++i <= last);
}

/// The one traversal behind both interfaces. With `any` it ends at the first hit and does not name it. Where nothing moves, all is in one
/// hierarchy (RESTIRPG_ONE_LEVEL): its addresses and the ray are then the same all along, which takes 7% off a path tracer's frame.
/// The rays of a vector all go down to their next leaves, then all meet them: Aila & Laine 2009, "Understanding the Efficiency of Ray
/// Traversal on GPUs", while-while. The inner loops have their conditions at the end, because CPU devices go once more through a body whose
/// condition stands before it (5 to 10% of a ray).
bool traverse(vec3 origin, vec3 direction, inout float t, bool any, out Hit hit)
{
    Stack stack = empty_stack();
    int node = 0;
    Found found = Found(0ul, INVALID_INDEX, INVALID_INDEX, vec2(0.0));
#if RESTIRPG_ONE_LEVEL
    Space space = batch_space(origin, direction);
#else
    Space space = world_space(origin, direction);
    bool in_world = true;
#endif
    while (node != STACK_EMPTY) {
        do {
            if (node >= 0) {
                BvhNode inner = load_node(space.nodes, node);
                int t0 = enter_box(inner.box0, space.ray, t);
                int t1 = enter_box(inner.box1, space.ray, t);
                bool swapped = t1 < t0;
                int near = swapped ? inner.child1 : inner.child0;
                int far = swapped ? inner.child0 : inner.child1;
                bool both = max(t0, t1) < MISSED;
                bool none = min(t0, t1) >= MISSED;
                node = none ? stack.top : near;
                step_stack(stack, both, none, far);
            }
        } while (node >= 0);
        bool at_leaf = node != STACK_EMPTY;
#if !RESTIRPG_ONE_LEVEL
        if (node == LEAVE_OBJECT) {
            at_leaf = false;
            in_world = true;
            space = world_space(origin, direction);
            node = stack.top;
            step_stack(stack, false, true, 0);
        } else if (at_leaf && in_world) {
            at_leaf = false;
            in_world = false;
            space = object_space(uint(~node) >> BVH_LEAF_BITS, origin, direction);
            node = 0;
            step_stack(stack, true, false, LEAVE_OBJECT);
        }
#endif
        if (at_leaf) {
            meet_leaf(node, space, t, found);
            node = any && found.index != INVALID_INDEX ? STACK_EMPTY : stack.top;
            step_stack(stack, false, true, 0);
        }
    }
    hit = Hit(INVALID_INDEX, 0u, vec2(0.0));
    if (found.index != INVALID_INDEX && !any)
        hit = name_hit(found);
    return found.index != INVALID_INDEX;
}

bool trace_closest(vec3 origin, vec3 direction, float t_max, out Hit hit, out float t)
{
    t = t_max;
    return traverse(origin, direction, t, false, hit);
}

bool trace_any(vec3 origin, vec3 direction, float t_max)
{
    Hit hit;
    return traverse(origin, direction, t_max, true, hit);
}

#endif
