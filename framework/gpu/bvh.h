// Two-child bounding volume hierarchies for the software back end, built by Embree's BVH builder.
#pragma once

#include "shaders/scene/scene_types.h"

#include <span>
#include <vector>

namespace restirpg {

struct Box {
    glm::vec3 lower{1e30f};
    glm::vec3 upper{-1e30f};

    void extend(glm::vec3 p)
    {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
};

/// A hierarchy over boxes. Leaves refer to ranges of `order`.
struct Bvh {
    BvhGrid grid;
    std::vector<BvhNode> nodes;  ///< the root first; at least one node
    /// Input indices in leaf order; with spatial splits an index can stand more than once
    std::vector<uint32_t> order;
};

/// Surface-area-heuristic build (binned) over at least one box, at most maxLeafSize <= 2^BVH_LEAF_BITS primitives a
/// leaf; where that would be too deep, of least depth. Deterministic: the same input gives the same nodes in the same
/// order.
Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeafSize);

/// The hierarchy of a triangle soup with its triangles in leaf order.
struct TriangleBvh {
    BvhGrid grid;
    std::vector<BvhNode> nodes;
    std::vector<BvhTriangle> triangles;
};

/// A triangle to build over, and what BvhTriangle says of it.
struct SourceTriangle {
    glm::vec3 corners[3];
    uint32_t instance;
    uint32_t triangle;
};

/// As buildBvh, with spatial splits (Stich et al. 2009): a triangle can stand in several leaves.
TriangleBvh buildTriangleBvh(std::span<const SourceTriangle> triangles);

}  // namespace restirpg
