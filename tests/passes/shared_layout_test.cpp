// Every struct that C++ and GLSL share lies in memory as the compiled kernels read it: offsets and sizes of C++ against
// SPIR-V's.
#include "gpu/shader.h"
#include "shaders/frame_types.h"
#include "shaders/math/double_single_types.h"
#include "shaders/restir/path_vertex_types.h"

#include "../../passes/Accumulate/Shared.h"
#include "../../passes/ErrorMeasure/Shared.h"
#include "../../passes/GBuffer/Shared.h"
#include "../../passes/GuidingChain/Shared.h"
#include "../../passes/GuidingFit/Shared.h"
#include "../../passes/GuidingScreen/Shared.h"
#include "../../passes/GuidingSplat/Shared.h"
#include "../../passes/GuidingView/Shared.h"
#include "../../passes/PathTracerGuided/Shared.h"
#include "../../passes/PathVertices/Shared.h"
#include "../../passes/ReSTIRDI/Shared.h"
#include "../../passes/ReSTIRReuse/Shared.h"
#include "../../passes/ToneMap/Shared.h"

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <cstddef>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace restirpg {
namespace {

struct Member {
    std::string name;
    uint32_t offset;  ///< bytes
    bool operator==(const Member&) const = default;
};

struct Layout {
    std::string name;
    uint32_t size;  ///< bytes
    std::vector<Member> members;
};

// FOR_EACH(m, S, a, b) is m(S, a) m(S, b).  [D. Mazieres, "Recursive macros with C++20 __VA_OPT__"]
#define PARENTHESES ()
#define EXPAND(...) EXPAND3(EXPAND3(EXPAND3(__VA_ARGS__)))
#define EXPAND3(...) EXPAND2(EXPAND2(EXPAND2(__VA_ARGS__)))
#define EXPAND2(...) EXPAND1(EXPAND1(EXPAND1(__VA_ARGS__)))
#define EXPAND1(...) __VA_ARGS__
#define FOR_EACH(macro, type, ...) __VA_OPT__(EXPAND(FOR_EACH_NEXT(macro, type, __VA_ARGS__)))
#define FOR_EACH_NEXT(macro, type, first, ...)                                                                         \
    macro(type, first) __VA_OPT__(FOR_EACH_AGAIN PARENTHESES(macro, type, __VA_ARGS__))
#define FOR_EACH_AGAIN() FOR_EACH_NEXT
#define MEMBER(type, member) Member{#member, uint32_t(offsetof(type, member))},
#define LAYOUT(type, ...)                                                                                              \
    Layout                                                                                                             \
    {                                                                                                                  \
#type, uint32_t(sizeof(type)),                                                                                 \
        {                                                                                                              \
            FOR_EACH(MEMBER, type, __VA_ARGS__)                                                                        \
        }                                                                                                              \
    }

const std::vector<Layout> LAYOUTS = {
    LAYOUT(TextureRef, row0, row1, index, uvSet),
    LAYOUT(Material, baseColor, metallic, specularColor, roughness, absorption, transmission, specular, ior,
           coatAverage, flags, emission, alpha, alphaCutoff, normalScale, energyTable, unused, baseColorMap,
           metallicRoughnessMap, specularMap, specularColorMap, transmissionMap, normalMap, emissiveMap),
    LAYOUT(MeshVertex, position, normal, uv0),
    LAYOUT(VertexExtras, tangent, uv1, color),
    LAYOUT(MeshTriangle, vertices, material),
    LAYOUT(Instance, objectToWorld, firstTriangle, triangleCount, lightMap, flipped),
    LAYOUT(Light, type, instance, triangle, pmf, aliasThreshold, alias, position, direction, intensity, cosInner,
           cosOuter, cells, cellsASide),
    LAYOUT(ImportanceCell, pdf, aliasThreshold, alias),
    LAYOUT(Camera, position, right, up, forward),
    LAYOUT(SceneTable, vertices, vertexExtras, triangles, materials, textures, instances, previousPoses, lights,
           lightOfTriangle, emissionCells, environmentCells, energyTables, tlasNodes, bvhObjects, tlasGrid,
           instanceCount, lightCount, environmentLight, environmentTexture, environmentSize, environmentRadiance,
           environmentRotation, center, radius),
    LAYOUT(BvhGrid, origin, scale, width, unused),
    LAYOUT(BvhNode, box0, box1, child0, child1),
    LAYOUT(BvhTriangle, corner0, corner1, corner2, instance, triangle, unused),
    LAYOUT(BvhObject, nodes, triangles, worldToObject, grid, instance, masked),
    LAYOUT(Hit, instance, triangle, barycentrics),
    LAYOUT(PrimaryHit, hit, normal, distance),
    LAYOUT(FrameConstants, scene, camera, previousCamera, size, corner, picture, frame, seed, reset, rescaled, time),
    LAYOUT(DoubleSingle3, high, low),
    LAYOUT(AccumulatorState, sum, deviation, count, invalid),
    LAYOUT(AccumulateParameters, frame, direct, indirect, emission, history, sums, value, mean, variance, invalid),
    LAYOUT(ErrorSums, reference, absolute, relativeSquared, squared, difference, valid),
    LAYOUT(MeasuredErrors, mape, relMse, rmse, bias, invalid),
    LAYOUT(ErrorMeasureParameters, frame, image, reference, lanes, total, map, errors),
    LAYOUT(GBufferParameters, frame, surface, emission, normal, geometricNormal, albedo, depth, motion, material,
           jitter),
    LAYOUT(ChainState, target, cosine, energy, samples),
    LAYOUT(ChainCell, states, age),
    LAYOUT(ChainHeader, table, spread, prior, largestKappa),
    LAYOUT(ChainProposals, best, weights, count),
    LAYOUT(GuidingChainParameters, frame, samples, history, guide, proposals, stride, capacity, product, oldest,
           cellSize, smallestCell, spread, decay, memory, prior, largestKappa),
    LAYOUT(ScreenStatistics, first, second, weight, squaredWeight, samples),
    LAYOUT(ScreenLobe, kind, mean, spread),
    LAYOUT(GuidingScreenParameters, frame, surface, previousSurface, motion, samples, history, statistics, guide,
           direction, peak, stride, kind, product, neighbours, smoothingFloor, prior, regularisation, normalThreshold,
           depthThreshold),
    LAYOUT(PathTracerParameters, frame, surface, radiance, candidates, guide, samples, bounces, nextEventEstimation,
           direct, alpha, trees, guidedBounces),
    LAYOUT(PathReservoir, f, ucw, confidence, shape, labels, pixel, frame, prefix, anchor, place, direction, geometry,
           suffix),
    LAYOUT(PathVertex, position, direction, surface),
    LAYOUT(GuidingSample, vertex, weight, distance),
    LAYOUT(PathImage, f, geometry, jacobian, anchor, place),
    LAYOUT(ReuseParameters, frame, surface, previousSurface, motion, source, history, reservoirs, radiance, images,
           partners, cap, round, rules),
    LAYOUT(PathVerticesParameters, frame, surface, paths, vertices),
    LAYOUT(GuidingGrid, camera, scale, origin, smallest),
    LAYOUT(GuidingHeader, grid, capacity, options, cells, collisions, failed, samples, fitted, guiding),
    LAYOUT(GuidingSums, lanes, strangest, bsdf, count),
    LAYOUT(GuidingDistanceSums, lanes),
    LAYOUT(GuidingLobe, direction, kappa, weight),
    LAYOUT(GuidingCell, lobes, state, samples),
    LAYOUT(GuidingMemory, sums, bsdf, count, inverseDistances),
    LAYOUT(GuidingSplatParameters, frame, surface, paths, samples, guide, statistics, stride, capacity, learnedBounces,
           finalEdges, incident, parallax, cellSize, smallestCell, rowStep),
    LAYOUT(GuidingFitParameters, frame, statistics, history, guide, capacity, options, remembers, keepsSamples, reseeds,
           oldest, lobes, decay, minimum, alphaPrior, weightPrior, concentrationPrior, largestKappa),
    LAYOUT(GuidingViewParameters, frame, surface, guide, image, show),
    LAYOUT(ToneMapParameters, frame, image, display, gain, white, curve),
    LAYOUT(LightPoint, instance, index, place),
    LAYOUT(LightReservoir, point, ucw, confidence, target),
    LAYOUT(ReSTIRDIParameters, frame, surface, previousSurface, motion, history, source, reservoirs, radiance,
           candidates, bsdfCandidates, round, pairwise, cap, rules),
    LAYOUT(NeighbourRules, neighbours, pool, radius, leastRadius, normalThreshold, depthThreshold),
};

/// A kernel that reads an array of each struct through a device address.
std::string kernelText()
{
    std::string declarations, uses;
    for (const Layout& layout : LAYOUTS) {
        declarations += fmt::format(
            "layout(buffer_reference, scalar, buffer_reference_align = 4) buffer {0}Array {{ {0} at[]; }};\n",
            layout.name);
        uses += fmt::format("    {0}Array(address).at[0] = {0}Array(address).at[1];\n", layout.name);
    }
    std::string includes =
        "#include \"prelude.glsl\"\n#include \"math/double_single_types.h\"\n#include \"restir/path_vertex_types.h\"\n";
    for (const char* pass :
         {"Accumulate", "ErrorMeasure", "GBuffer", "GuidingChain", "GuidingFit", "GuidingScreen", "GuidingSplat",
          "GuidingView", "PathTracerGuided", "PathVertices", "ReSTIRDI", "ReSTIRReuse", "ToneMap"})
        includes += fmt::format("#include \"{}/passes/{}/Shared.h\"\n", RESTIRPG_SOURCE, pass);
    return "#version 460\n" + includes +
           "layout(local_size_x = 1) in;\nlayout(push_constant) uniform Push { Address address; };\n" + declarations +
           "void main()\n{\n" + uses + "}\n";
}

/// The structs of a SPIR-V module that lie in buffers, by name.  [SPIR-V 1.5, sections 2.3 and 3.32]
std::map<std::string, Layout> readLayouts(const std::vector<uint32_t>& spirv)
{
    constexpr uint32_t NAME = 5, MEMBER_NAME = 6, TYPE_RUNTIME_ARRAY = 29, DECORATE = 71, MEMBER_DECORATE = 72;
    constexpr uint32_t ARRAY_STRIDE = 6, OFFSET = 35, HEADER_WORDS = 5;
    std::map<uint32_t, std::string> names;
    std::map<uint32_t, std::map<uint32_t, Member>> members;
    std::map<uint32_t, uint32_t> strides, elementOf;
    for (size_t i = HEADER_WORDS; i < spirv.size(); i += spirv[i] >> 16) {
        const uint32_t* word = &spirv[i];
        switch (word[0] & 0xffffu) {
        case NAME:
            names[word[1]] = reinterpret_cast<const char*>(word + 2);
            break;
        case MEMBER_NAME:
            members[word[1]][word[2]].name = reinterpret_cast<const char*>(word + 3);
            break;
        case MEMBER_DECORATE:
            if (word[3] == OFFSET)
                members[word[1]][word[2]].offset = word[4];
            break;
        case DECORATE:
            if (word[2] == ARRAY_STRIDE)
                strides[word[1]] = word[3];
            break;
        case TYPE_RUNTIME_ARRAY:
            elementOf[word[1]] = word[2];
            break;
        default:
            break;
        }
    }
    std::map<std::string, Layout> layouts;
    for (const auto& [array, element] : elementOf) {
        Layout& layout = layouts[names[element]];
        layout = {names[element], strides[array], {}};
        for (const auto& [index, member] : members[element])
            layout.members.push_back(member);
    }
    return layouts;
}

TEST(SharedLayout, EveryStructLiesInMemoryAsKernelsReadIt)
{
    const auto file = std::filesystem::temp_directory_path() / fmt::format("restirpg-layout-{}.comp", getpid());
    std::ofstream(file) << kernelText();
    const auto layouts = readLayouts(compileShader(file));
    std::filesystem::remove(file);
    for (const Layout& expected : LAYOUTS) {
        SCOPED_TRACE(expected.name);
        ASSERT_TRUE(layouts.contains(expected.name));
        const Layout& actual = layouts.at(expected.name);
        EXPECT_EQ(actual.size, expected.size);
        ASSERT_EQ(actual.members.size(), expected.members.size()) << "a member is missing in this test's table";
        for (size_t m = 0; m < expected.members.size(); ++m) {
            EXPECT_EQ(actual.members[m].name, expected.members[m].name);
            EXPECT_EQ(actual.members[m].offset, expected.members[m].offset) << expected.members[m].name;
        }
    }
}

}  // namespace
}  // namespace restirpg
