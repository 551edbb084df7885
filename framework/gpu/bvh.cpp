#include "gpu/bvh.h"

#include "core/error.h"

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <algorithm>
#include <array>
#include <deque>
#include <memory>

namespace restirpg {
namespace {

constexpr uint32_t MAX_DEPTH = 40;  // with TLAS_DEPTH and the way out of an instance below BVH_STACK
constexpr uint32_t SPLIT_CAPACITY = 2;  // room for references made by spatial splits, times the triangles
constexpr uint32_t TLAS_DEPTH = 22;

/// The grid that spans the box. No cell is smaller than the distance of floats there, or nothing.
BvhGrid gridOver(const Box& box)
{
    constexpr float CELLS = 65534;  // one less than there are: the last one rounds
    const glm::vec3 far = glm::max(glm::abs(box.lower), glm::abs(box.upper));
    const glm::vec3 extent = box.upper - box.lower;
    // Across a flat box they are no finer than what rays widen it by (on_grid of trace_software.glsl): from afar,
    // coordinates stay finite.
    const float finest = std::max(0x1p-24f * std::max({extent.x, extent.y, extent.z}), 1e-30f);
    const glm::vec3 cell = glm::max(glm::max(extent / CELLS, far * 0x1p-23f), glm::vec3(finest));
    return {box.lower, 1.0f / cell, CELLS * std::max({cell.x, cell.y, cell.z}), 0};
}

/// A box on the grid, rounded outwards.
glm::uvec3 toGrid(const BvhGrid& grid, const Box& box)
{
    const auto coordinates = [&](glm::vec3 p) {
        return (glm::dvec3(p) - glm::dvec3(grid.origin)) * glm::dvec3(grid.scale);
    };
    const auto within = [](glm::dvec3 q) { return glm::uvec3(glm::clamp(q, 0.0, 65535.0)); };
    return within(glm::floor(coordinates(box.lower))) | within(glm::ceil(coordinates(box.upper))) << 16u;
}

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

/// What spatial splits need of a triangle soup.
struct Splitting {
    std::span<const SourceTriangle> triangles;
    glm::vec3 rounding;  ///< m, along each axis: above what Embree's arithmetic may move a point by
};

/// Four floats, of which three are used: their minimum and maximum are single instructions.
using Four = float __attribute__((vector_size(16)));

Four four(glm::vec3 p)
{
    return Four{p.x, p.y, p.z, 0};
}

Four least(Four a, Four b)
{
    return a < b ? a : b;
}

Four most(Four a, Four b)
{
    return a > b ? a : b;
}

/// Embree's callback of a spatial split: the bounds of the two parts of a triangle, cut at a plane across an axis.
/// Nearly half of the time that a hierarchy takes is spent here.
void splitTriangle(const RTCBuildPrimitive* primitive, unsigned axis, float plane, RTCBounds* left, RTCBounds* right,
                   void* user)
{
    const auto& splitting = *static_cast<const Splitting*>(user);
    const auto& corners = splitting.triangles[primitive->primID].corners;
    const Four nothing = Four{} + 1e30f;
    Four belowLower = nothing, belowUpper = -nothing, aboveLower = nothing, aboveUpper = -nothing;
    for (int i = 0; i < 3; ++i) {
        const glm::vec3 &a = corners[i], &b = corners[i == 2 ? 0 : i + 1];
        const float from = a[int(axis)], to = b[int(axis)];
        const Four corner = four(a);
        if (from <= plane) {
            belowLower = least(belowLower, corner);
            belowUpper = most(belowUpper, corner);
        }
        if (from >= plane) {
            aboveLower = least(aboveLower, corner);
            aboveUpper = most(aboveUpper, corner);
        }
        if ((from < plane && plane < to) || (to < plane && plane < from)) {
            const Four cut = corner + (four(b) - corner) * ((plane - from) / (to - from));
            belowLower = least(belowLower, cut);
            belowUpper = most(belowUpper, cut);
            aboveLower = least(aboveLower, cut);
            aboveUpper = most(aboveUpper, cut);
        }
    }
    // The primitive may be a part already: stay inside its bounds.
    const Four lower{primitive->lower_x, primitive->lower_y, primitive->lower_z, 0};
    const Four upper{primitive->upper_x, primitive->upper_y, primitive->upper_z, 0};
    using Mask = int __attribute__((vector_size(16)));
    constexpr Mask ACROSS[3] = {{-1, 0, 0, 0}, {0, -1, 0, 0}, {0, 0, -1, 0}};
    const Mask across = ACROSS[axis];
    const Four at = Four{} + plane, rounding = four(splitting.rounding);
    const auto store = [&](Four low, Four high, bool below, RTCBounds& bounds) {
        low = most(low, lower);
        high = least(high, upper);
        (below ? high : low) = across ? at : (below ? high : low);
        const Mask inverted = low > high;
        if (inverted[0] | inverted[1] | inverted[2]) {  // nothing of it is left there, by these bounds
            low = lower;
            high = upper;
            (below ? high : low) = across ? at : (below ? high : low);
        }
        if (below)
            low = across ? least(low, at - rounding) : low;
        else
            high = across ? most(high, at + rounding) : high;
        bounds = {low[0], low[1], low[2], 0, high[0], high[1], high[2], 0};
    };
    // Embree counts a part on the side of the plane that it is cut for, and later sorts it by its middle. An empty part
    // stays uncut, and one that is thinner than rounding can have its middle on the other side. Where that leaves a
    // side without any, Debian's Embree, which is built with its assertions, ends the process.
    store(belowLower, belowUpper, true, *left);
    store(aboveLower, aboveUpper, false, *right);
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
        bvh_.nodes[index] = {toGrid(bvh_.grid, node->bounds[0]), toGrid(bvh_.grid, node->bounds[1]), child0, child1};
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

/// Embree's device, once a process. Its builder is deterministic in shape; threads only change where nodes lie in
/// memory.
RTCDevice builderDevice()
{
    static const std::shared_ptr<RTCDeviceTy> device(rtcNewDevice(nullptr), rtcReleaseDevice);
    return device.get();
}

Box boundsOf(std::span<const RTCBuildPrimitive> primitives)
{
    Box bounds;
    for (const auto& p : primitives) {
        bounds.extend({p.lower_x, p.lower_y, p.lower_z});
        bounds.extend({p.upper_x, p.upper_y, p.upper_z});
    }
    return bounds;
}

/// The tree of least depth, one primitive a leaf: halves along the longest axis. `nodes` keeps it.
TreeNode* buildBalanced(std::span<RTCBuildPrimitive> primitives, std::deque<TreeNode>& nodes)
{
    TreeNode& node = nodes.emplace_back();
    if (primitives.size() == 1) {
        node.first = primitives.data();
        node.count = 1;
        return &node;
    }
    const Box bounds = boundsOf(primitives);
    const glm::vec3 extent = bounds.upper - bounds.lower;
    const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
    const auto place = [axis](const RTCBuildPrimitive& p) {
        const Box box = boundsOf({&p, 1});
        return std::pair(0.5f * box.lower[axis] + 0.5f * box.upper[axis], p.primID);
    };
    const size_t half = primitives.size() / 2;
    std::nth_element(primitives.begin(), primitives.begin() + std::ptrdiff_t(half), primitives.end(),
                     [&](const auto& a, const auto& b) { return place(a) < place(b); });
    const auto first = primitives.first(half), second = primitives.subspan(half);
    node.children = {buildBalanced(first, nodes), buildBalanced(second, nodes)};
    node.bounds = {boundsOf(first), boundsOf(second)};
    return &node;
}

Bvh build(std::span<const Box> boxes, uint32_t maxLeafSize, std::span<const SourceTriangle> triangles)
{
    Box all;
    for (const auto& box : boxes) {
        all.extend(box.lower);
        all.extend(box.upper);
    }
    Bvh bvh{gridOver(all), {}, {}};
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
    arguments.primitiveCount = primitives.size();
    Splitting splitting{triangles, 0x1p-20f * glm::max(glm::abs(all.lower), glm::abs(all.upper))};
    if (!triangles.empty()) {
        arguments.buildQuality = RTC_BUILD_QUALITY_HIGH;
        arguments.splitPrimitive = splitTriangle;
        arguments.userPtr = &splitting;
        primitives.resize(primitives.size() * SPLIT_CAPACITY);
    }
    arguments.primitives = primitives.data();
    arguments.primitiveArrayCapacity = primitives.size();
    arguments.createNode = createNode;
    arguments.setNodeChildren = setChildren;
    arguments.setNodeBounds = setBounds;
    arguments.createLeaf = createLeaf;
    const auto* root = static_cast<const TreeNode*>(rtcBuildBVH(&arguments));
    if (!root && !triangles.empty()) {  // spatial splits do not end where very many triangles lie in one place
        arguments.buildQuality = RTC_BUILD_QUALITY_MEDIUM;
        primitives = toPrimitives(boxes);
        arguments.primitives = primitives.data();
        arguments.primitiveArrayCapacity = primitives.size();
        rtcGetDeviceError(builderDevice());  // clears the first attempt's error
        root = static_cast<const TreeNode*>(rtcBuildBVH(&arguments));
    }
    std::deque<TreeNode> balanced;
    const RTCError error = root ? RTC_ERROR_NONE : rtcGetDeviceError(builderDevice());
    if (!root && error != RTC_ERROR_OUT_OF_MEMORY && boxes.size() <= uint64_t(1) << arguments.maxDepth) {
        primitives = toPrimitives(boxes);  // they lie so that the heuristic's tree would be too deep
        root = buildBalanced(primitives, balanced);
    }
    if (!root)
        fail("the bounding volume hierarchy of {} {} could not be built (Embree error {}); free memory, or "
             "use a smaller scene",
             boxes.size(), maxLeafSize == 1 ? "instances" : "triangles", int(error));

    if (root->first) {  // twice the same leaf, the second seen as a point that most rays miss
        const int leaf = Flattener(bvh).add(root);
        bvh.nodes.push_back({toGrid(bvh.grid, all), toGrid(bvh.grid, {all.lower, all.lower}), leaf, leaf});
        return bvh;
    }
    Flattener(bvh).add(root);
    return bvh;
}

}  // namespace

Bvh buildBvh(std::span<const Box> boxes, uint32_t maxLeafSize)
{
    return build(boxes, maxLeafSize, {});
}

TriangleBvh buildTriangleBvh(std::span<const SourceTriangle> triangles)
{
    std::vector<Box> boxes(triangles.size());
    for (size_t i = 0; i < triangles.size(); ++i)
        for (const auto& corner : triangles[i].corners)
            boxes[i].extend(corner);
    constexpr uint32_t MAX_LEAF = 4;
    Bvh bvh = build(boxes, MAX_LEAF, triangles);
    TriangleBvh result{bvh.grid, std::move(bvh.nodes), {}};
    result.triangles.reserve(bvh.order.size());
    for (uint32_t i : bvh.order) {
        const auto& t = triangles[i];
        result.triangles.push_back({t.corners[0], t.corners[1], t.corners[2], t.instance, t.triangle, 0});
    }
    return result;
}

}  // namespace restirpg
