#include "gpu/bvh.h"

#include "core/error.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <memory>

namespace restirpg {
namespace {

constexpr uint32_t MAX_DEPTH = 40;  // with TLAS_DEPTH and the way out of an instance below BVH_STACK
constexpr uint32_t TLAS_DEPTH = 22;

/// The tree as Embree's callbacks make it, before it is flattened.
struct TreeNode {
    std::array<TreeNode*, 2> children{};
    std::array<Box, 2> bounds;
    const RTCBuildPrimitive* first = nullptr;  ///< leaf
    size_t count = 0;
};

Box toBox(const RTCBounds& b)
{
    return {{b.lower_x, b.lower_y, b.lower_z}, {b.upper_x, b.upper_y, b.upper_z}};
}

void* createNode(RTCThreadLocalAllocator allocator, unsigned, void*)
{
    return new (rtcThreadLocalAlloc(allocator, sizeof(TreeNode), 16)) TreeNode;
}

void setChildren(void* node, void** children, unsigned count, void*)
{
    for (unsigned i = 0; i < count; ++i)
        static_cast<TreeNode*>(node)->children[i] = static_cast<TreeNode*>(children[i]);
}

void setBounds(void* node, const RTCBounds** bounds, unsigned count, void*)
{
    for (unsigned i = 0; i < count; ++i)
        static_cast<TreeNode*>(node)->bounds[i] = toBox(*bounds[i]);
}

void* createLeaf(RTCThreadLocalAllocator allocator, const RTCBuildPrimitive* primitives, size_t count, void*)
{
    auto* leaf = new (rtcThreadLocalAlloc(allocator, sizeof(TreeNode), 16)) TreeNode;
    leaf->first = primitives;
    leaf->count = count;
    return leaf;
}

/// Depth-first copy of the tree into the flat form.
class Flattener {
public:
    explicit Flattener(Bvh& bvh) : bvh_(bvh) {}

    int add(const TreeNode* node)
    {
        if (!node)
            return ~0;
        if (node->first) {
            // Within a leaf by input index: the builder's order depends on its threads.
            std::vector<uint32_t> ids;
            for (size_t i = 0; i < node->count; ++i)
                ids.push_back(node->first[i].primID);
            std::sort(ids.begin(), ids.end());
            const int leaf = ~int(bvh_.order.size() << BVH_LEAF_BITS | (node->count - 1));
            bvh_.order.insert(bvh_.order.end(), ids.begin(), ids.end());
            return leaf;
        }
        const size_t index = bvh_.nodes.size();
        bvh_.nodes.emplace_back();
        const int child0 = add(node->children[0]);
        const int child1 = add(node->children[1]);
        bvh_.nodes[index] = {node->bounds[0].lower, node->bounds[0].upper, node->bounds[1].lower,
                             node->bounds[1].upper, child0,                child1};
        return int(index);
    }

private:
    Bvh& bvh_;
};

std::vector<RTCBuildPrimitive> toPrimitives(std::span<const Box> boxes)
{
    std::vector<RTCBuildPrimitive> primitives;
    primitives.reserve(boxes.size());
    for (const auto& box : boxes)
        primitives.push_back({box.lower.x, box.lower.y, box.lower.z, 0, box.upper.x, box.upper.y, box.upper.z,
                              uint32_t(primitives.size())});
    return primitives;
}

/// Embree's device, once a process. Its builder is deterministic in shape; threads only change where nodes lie in memory.
RTCDevice builderDevice()
{
    static const std::shared_ptr<RTCDeviceTy> device(rtcNewDevice(nullptr), rtcReleaseDevice);
    return device.get();
}

}  // namespace

Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeafSize)
{
    Bvh bvh;
    if (boxes.empty()) {
        const Box nothing;
        bvh.nodes.push_back({nothing.lower, nothing.upper, nothing.lower, nothing.upper, ~0, ~0});
        return bvh;
    }
    auto primitives = toPrimitives(boxes);
    const std::unique_ptr<RTCBVHTy, decltype(&rtcReleaseBVH)> builder(rtcNewBVH(builderDevice()), rtcReleaseBVH);
    RTCBuildArguments arguments = rtcDefaultBuildArguments();
    arguments.bvh = builder.get();
    arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
    arguments.maxBranchingFactor = 2;
    arguments.maxDepth = maxLeafSize == 1 ? TLAS_DEPTH : MAX_DEPTH;
    arguments.sahBlockSize = 1;
    arguments.minLeafSize = 1;
    arguments.maxLeafSize = maxLeafSize;
    arguments.traversalCost = 1;
    arguments.intersectionCost = 1;
    arguments.primitives = primitives.data();
    arguments.primitiveCount = arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = createNode;
    arguments.setNodeChildren = setChildren;
    arguments.setNodeBounds = setBounds;
    arguments.createLeaf = createLeaf;
    const auto* root = static_cast<const TreeNode*>(rtcBuildBVH(&arguments));
    if (!root)
        fail("the bounding volume hierarchy of {} primitives could not be built (Embree error {}); is memory short?",
             boxes.size(), int(rtcGetDeviceError(builderDevice())));

    if (root->first) {
        Box all;
        for (const auto& box : boxes) {
            all.extend(box.lower);
            all.extend(box.upper);
        }
        const Box nothing;
        bvh.nodes.push_back({all.lower, all.upper, nothing.lower, nothing.upper, 0, ~0});
        bvh.nodes[0].child0 = Flattener(bvh).add(root);
        return bvh;
    }
    Flattener(bvh).add(root);
    return bvh;
}

TriangleBvh buildTriangleBvh(std::span<const glm::vec3> positions, std::span<const glm::uvec3> triangles)
{
    std::vector<Box> boxes(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i)
        for (int corner = 0; corner < 3; ++corner)
            boxes[i].extend(positions[triangles[i][corner]]);
    constexpr uint32_t MAX_LEAF = 4;
    Bvh bvh = buildBvh(boxes, MAX_LEAF);
    TriangleBvh result{std::move(bvh.nodes), {}};
    result.triangles.reserve(bvh.order.size());
    for (uint32_t i : bvh.order) {
        const auto& t = triangles[i];
        result.triangles.push_back(
            {positions[t.x], positions[t.y] - positions[t.x], positions[t.z] - positions[t.x], i});
    }
    return result;
}

}  // namespace restirpg
