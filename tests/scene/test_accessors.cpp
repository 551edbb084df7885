// Geometry: every accessor layout of glTF 2.0 yields the same triangles.
#include "gltf_builder.h"

#include <glm/gtc/matrix_transform.hpp>
#include <gtest/gtest.h>

using namespace restirpg;
using nlohmann::json;

namespace {

/// One triangle with its uv in a component type, as the file stores it.
template <typename T>
Scene triangleWithUv(const std::vector<T>& uv, int componentType, bool normalized)
{
    GltfBuilder builder;
    json primitive;
    primitive["attributes"]["POSITION"] =
        builder.addAccessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0}, FLOAT, "VEC3");
    primitive["attributes"]["TEXCOORD_0"] = builder.addAccessor(uv, componentType, "VEC2", normalized);
    builder.addNode({{"mesh", builder.addMesh(primitive)}});
    return load(builder);
}

void expectUv(const Scene& scene, glm::vec2 first, glm::vec2 second)
{
    ASSERT_EQ(scene.attributes.size(), 3u);
    EXPECT_NEAR(scene.attributes[0].uv0.x, first.x, 1e-6f);
    EXPECT_NEAR(scene.attributes[0].uv0.y, first.y, 1e-6f);
    EXPECT_NEAR(scene.attributes[1].uv0.x, second.x, 1e-6f);
    EXPECT_NEAR(scene.attributes[1].uv0.y, second.y, 1e-6f);
}

std::vector<glm::vec3> corners(const Scene& scene, size_t triangle)
{
    const auto t = fromEarliestVertex(scene.triangles[triangle]);
    return {scene.positions[t.x], scene.positions[t.y], scene.positions[t.z]};
}

/// Five points on a line zigzag as positions only, drawn in a mode.
Scene zigzag(int mode)
{
    GltfBuilder builder;
    const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0};
    json primitive = {{"mode", mode}};
    primitive["attributes"]["POSITION"] = builder.addAccessor(positions, FLOAT, "VEC3");
    builder.addNode({{"mesh", builder.addMesh(primitive)}});
    return load(builder);
}

}  // namespace

TEST(Accessors, EveryComponentTypeIsReadAsItsNumber)
{
    expectUv(triangleWithUv<float>({0.25f, -2, 3, 4, 0, 0}, FLOAT, false), {0.25f, -2}, {3, 4});
    expectUv(triangleWithUv<uint8_t>({7, 255, 3, 4, 0, 0}, UNSIGNED_BYTE, false), {7, 255}, {3, 4});
    expectUv(triangleWithUv<int8_t>({7, -128, 3, 4, 0, 0}, BYTE, false), {7, -128}, {3, 4});
    expectUv(triangleWithUv<uint16_t>({7, 65535, 3, 4, 0, 0}, UNSIGNED_SHORT, false), {7, 65535}, {3, 4});
    expectUv(triangleWithUv<int16_t>({7, -32768, 3, 4, 0, 0}, SHORT, false), {7, -32768}, {3, 4});
}

TEST(Accessors, NormalizedIntegersFollowTheSpecificationsQuotients)
{
    expectUv(triangleWithUv<uint8_t>({0, 255, 51, 102, 0, 0}, UNSIGNED_BYTE, true), {0, 1}, {0.2f, 0.4f});
    expectUv(triangleWithUv<int8_t>({127, -127, -128, 0, 0, 0}, BYTE, true), {1, -1}, {-1, 0});
    expectUv(triangleWithUv<uint16_t>({0, 65535, 13107, 0, 0, 0}, UNSIGNED_SHORT, true), {0, 1}, {0.2f, 0});
    expectUv(triangleWithUv<int16_t>({32767, -32767, -32768, 0, 0, 0}, SHORT, true), {1, -1}, {-1, 0});
}

TEST(Accessors, InterleavedBufferViewsAreWalkedByTheirStride)
{
    GltfBuilder builder;
    const std::vector<float> interleaved = {0, 0, 0, 0.1f, 0.2f, 1, 0, 0, 0.3f, 0.4f, 0, 1, 0, 0.5f, 0.6f};
    const int view = builder.addView(interleaved.data(), interleaved.size() * 4, 20);
    json primitive;
    primitive["attributes"]["POSITION"] =
        builder.addAccessorJson({{"bufferView", view}, {"componentType", FLOAT}, {"count", 3}, {"type", "VEC3"}});
    primitive["attributes"]["TEXCOORD_0"] = builder.addAccessorJson(
        {{"bufferView", view}, {"byteOffset", 12}, {"componentType", FLOAT}, {"count", 3}, {"type", "VEC2"}});
    builder.addNode({{"mesh", builder.addMesh(primitive)}});
    const auto scene = load(builder);
    EXPECT_EQ(scene.positions[2], glm::vec3(0, 1, 0));
    EXPECT_EQ(scene.attributes[2].uv0, glm::vec2(0.5f, 0.6f));
}

TEST(Accessors, SparseElementsReplaceTheirBase)
{
    const auto scene = load(geometryScene());
    // The square's vertex 1 was (1, 0, 0); it is the third primitive, after two triangles of the strip and two of
    // the fan.
    EXPECT_EQ(corners(scene, 4)[1], glm::vec3(3, 0, 0));
    EXPECT_EQ(corners(scene, 4)[2], glm::vec3(1, 1, 0));
}

TEST(Accessors, SparseWithoutABufferViewStartsFromZeros)
{
    GltfBuilder builder;
    const int indices = builder.addView(std::vector<uint8_t>{1, 2}.data(), 2);
    const int values = builder.addView(std::vector<float>{1, 0, 0, 0, 1, 0}.data(), 24);
    json primitive;
    primitive["attributes"]["POSITION"] =
        builder.addAccessorJson({{"componentType", FLOAT},
                                 {"count", 3},
                                 {"type", "VEC3"},
                                 {"sparse",
                                  {{"count", 2},
                                   {"indices", {{"bufferView", indices}, {"componentType", UNSIGNED_BYTE}}},
                                   {"values", {{"bufferView", values}}}}}});
    builder.addNode({{"mesh", builder.addMesh(primitive)}});
    EXPECT_EQ(corners(load(builder), 0), (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
}

namespace {

/// The square with some of its indices replaced by a sparse part: their places, and what stands there.
GltfBuilder squareOfSparseIndices(const std::vector<uint8_t>& places, const std::vector<uint32_t>& replacements,
                                  bool hasBase)
{
    GltfBuilder builder;
    auto primitive = addSquare(builder);
    json accessor = {
        {"componentType", UNSIGNED_INT},
        {"count", 6},
        {"type", "SCALAR"},
        {"sparse",
         {{"count", places.size()},
          {"indices",
           {{"bufferView", builder.addView(places.data(), places.size())}, {"componentType", UNSIGNED_BYTE}}},
          {"values", {{"bufferView", builder.addView(replacements.data(), 4 * replacements.size())}}}}}};
    if (hasBase)
        accessor["bufferView"] = builder.addView(std::vector<uint32_t>{0, 1, 2, 0, 2, 3}.data(), 24);
    primitive["indices"] = builder.addAccessorJson(accessor);
    builder.addNode({{"mesh", builder.addMesh(primitive, "Square")}});
    return builder;
}

}  // namespace

TEST(Accessors, IndicesMayBeSparse)
{
    const std::vector<glm::vec3> lower = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}};
    const auto based = load(squareOfSparseIndices({3}, {1}, true));
    ASSERT_EQ(based.triangles.size(), 2u);
    EXPECT_EQ(corners(based, 0), lower);
    EXPECT_EQ(corners(based, 1), (std::vector<glm::vec3>{{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    const auto zeros = load(squareOfSparseIndices({1, 2, 4, 5}, {1, 2, 2, 3}, false));
    ASSERT_EQ(zeros.triangles.size(), 2u);
    EXPECT_EQ(corners(zeros, 0), lower);
    EXPECT_EQ(corners(zeros, 1), (std::vector<glm::vec3>{{0, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
    for (const bool hasBase : {false, true}) {
        // The next float is 16777218.
        EXPECT_NE(errorOf(squareOfSparseIndices({3}, {16777217}, hasBase)).find("index 3 is 16777217"),
                  std::string::npos);
        EXPECT_NE(errorOf(squareOfSparseIndices({6}, {1}, hasBase)).find("replaces element 6 of 6"), std::string::npos);
    }
}

TEST(Accessors, QuantizedAndStridedAttributesKeepTheirValues)
{
    const auto scene = load(geometryScene());
    EXPECT_EQ(corners(scene, 0), (std::vector<glm::vec3>{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}));
    EXPECT_EQ(scene.attributes[0].normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(scene.attributes[1].color, glm::vec4(0, 1, 0, 1));
}

TEST(Geometry, StripsAlternateTheirWinding)
{
    const auto scene = zigzag(5);
    ASSERT_EQ(scene.triangles.size(), 3u);
    for (const auto& vertex : scene.attributes)
        EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(corners(scene, 1), (std::vector<glm::vec3>{{1, 0, 0}, {1, 1, 0}, {0, 1, 0}}));
}

TEST(Geometry, FansShareTheFirstVertex)
{
    const auto scene = zigzag(6);
    ASSERT_EQ(scene.triangles.size(), 3u);
    for (size_t t = 0; t < 3; ++t)
        EXPECT_EQ(corners(scene, t)[2], glm::vec3(0, 0, 0));
}

/// Listed from each of its corners, flat and as a node stretches it, which makes another edge the longest.
TEST(Geometry, TrianglesStartOppositeTheirLongestEdge)
{
    const std::vector<glm::vec3> corners = {{0, 0, 0}, {2, 0, 0}, {1.2f, 0.5f, 0}};
    for (const auto& [height, widest] : {std::pair(1.0f, 2u), std::pair(10.0f, 1u)})
        for (size_t first = 0; first < 3; ++first) {
            std::vector<float> positions;
            for (size_t i = 0; i < 3; ++i)
                for (int axis = 0; axis < 3; ++axis)
                    positions.push_back(corners[(first + i) % 3][axis]);
            GltfBuilder builder;
            json primitive;
            primitive["attributes"]["POSITION"] = builder.addAccessor(positions, FLOAT, "VEC3");
            builder.addNode({{"mesh", builder.addMesh(primitive)}, {"scale", {1, height, 1}}});
            const auto scene = load(builder);
            for (size_t i = 0; i < 3; ++i)
                EXPECT_EQ(scene.positions[scene.triangles[0][int(i)]], corners[(widest + i) % 3])
                    << "listed from corner " << first << ", " << height << " times as high";
        }
}

/// Two edges are the longest: a triangle that was turned to another corner is turned back to the one it had.
TEST(Geometry, EqualEdgesAreTakenByTheirVertices)
{
    GltfBuilder builder;
    json primitive;
    const std::vector<float> positions = {-1, 0, 0, 0, 5, 0, 1, 0, 0};
    primitive["attributes"]["POSITION"] = builder.addAccessor(positions, FLOAT, "VEC3");
    builder.addNode({{"mesh", builder.addMesh(primitive)}});
    auto scene = load(builder);
    const auto loaded = scene.triangles[0];
    scene.nodes[0].matrix = glm::scale(glm::mat4(1), glm::vec3(10, 1, 1));
    startAtWidestCorners(scene);
    EXPECT_NE(scene.triangles[0], loaded);
    scene.nodes[0].matrix.reset();
    startAtWidestCorners(scene);
    EXPECT_EQ(scene.triangles[0], loaded);
}

TEST(Geometry, LeftoverCornersOfATriangleListAreDropped)
{
    EXPECT_EQ(zigzag(4).triangles.size(), 1u);
}

TEST(Geometry, MissingNormalsAreFlatAndUnshared)
{
    auto builder = squareScene();
    auto& attributes = builder.json["meshes"][0]["primitives"][0]["attributes"];
    EXPECT_EQ(load(builder).positions.size(), 4u);
    attributes.erase("NORMAL");
    const auto scene = load(builder);
    EXPECT_EQ(scene.positions.size(), 6u);
    for (const auto& vertex : scene.attributes)
        EXPECT_EQ(vertex.normal, glm::vec3(0, 0, 1));
}

TEST(Geometry, ZeroNormalsBecomeTheTriangles)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
        builder.addAccessor(std::vector<float>{0, 0, 0, 0, 0, -2, 0, 0, -1, 0, 0, -1}, FLOAT, "VEC3");
    const auto scene = load(builder);
    EXPECT_EQ(scene.attributes[0].normal, glm::vec3(0, 0, 1));
    EXPECT_EQ(scene.attributes[1].normal, glm::vec3(0, 0, -1));
}

TEST(Geometry, DegenerateTrianglesStayHarmless)
{
    auto builder = squareScene();
    auto& primitive = builder.json["meshes"][0]["primitives"][0];
    primitive["attributes"].erase("NORMAL");
    primitive["indices"] = builder.addAccessor(std::vector<uint16_t>{0, 0, 1, 0, 1, 2}, UNSIGNED_SHORT, "SCALAR");
    const auto scene = load(builder);
    EXPECT_EQ(scene.triangles.size(), 2u);
    for (const auto& vertex : scene.attributes)
        EXPECT_FLOAT_EQ(glm::length(vertex.normal), 1);
}

TEST(Geometry, UnusedVerticesAreNotCopied)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["indices"] =
        builder.addAccessor(std::vector<uint16_t>{0, 2, 3}, UNSIGNED_SHORT, "SCALAR");
    EXPECT_EQ(load(builder).positions.size(), 3u);
}

namespace {

/// The square with a normal map and changed texture coordinates.
Scene normalMapped(const std::vector<float>& uv, const json& transform = nullptr)
{
    auto builder = squareScene();
    json map = {{"index", builder.addTexture(encodePng(1, 1, {128, 128, 255, 255}))}};
    if (!transform.is_null())
        map["extensions"]["KHR_texture_transform"] = transform;
    auto& primitive = builder.json["meshes"][0]["primitives"][0];
    primitive["material"] = builder.addMaterial({{"normalTexture", map}});
    primitive["attributes"]["TEXCOORD_0"] = builder.addAccessor(uv, FLOAT, "VEC2");
    return load(builder);
}

}  // namespace

TEST(Tangents, AnUprightImageHasItsTangentToTheRightAndItsBitangentUp)
{
    const auto scene = normalMapped({0, 1, 1, 1, 1, 0, 0, 0});
    ASSERT_EQ(scene.attributes.size(), 4u);
    for (const auto& vertex : scene.attributes) {
        EXPECT_EQ(vertex.tangent, glm::vec4(1, 0, 0, 1));
        EXPECT_EQ(glm::cross(vertex.normal, glm::vec3(vertex.tangent)) * vertex.tangent.w, glm::vec3(0, 1, 0));
    }
}

TEST(Tangents, AMirroredImageFlipsTheBitangentsSign)
{
    for (const auto& vertex : normalMapped({1, 1, 0, 1, 0, 0, 1, 0}).attributes)
        EXPECT_EQ(vertex.tangent, glm::vec4(-1, 0, 0, -1));
}

TEST(Tangents, VerticesWhereMirroredTrianglesMeetAreSplit)
{
    // The first triangle is upright; moving vertex 3 to the right of the diagonal in uv mirrors the second one.
    const auto scene = normalMapped({0, 1, 1, 1, 1, 0, 1, 1});
    EXPECT_EQ(scene.positions.size(), 6u);
    int positive = 0;
    for (const auto& vertex : scene.attributes)
        positive += vertex.tangent.w > 0;
    EXPECT_EQ(positive, 3);
}

TEST(Tangents, TheTextureTransformTurnsThem)
{
    const auto scene = normalMapped({0, 1, 1, 1, 1, 0, 0, 0}, {{"scale", {-1, 1}}});
    EXPECT_EQ(scene.attributes[0].tangent, glm::vec4(-1, 0, 0, -1));
}

TEST(Tangents, CollapsedTextureCoordinatesLeaveNone)
{
    EXPECT_EQ(normalMapped({0, 0, 0, 0, 0, 0, 0, 0}).attributes[0].tangent, glm::vec4(0));
}

TEST(Tangents, GivenOnesAreKept)
{
    auto builder = squareScene();
    builder.json["meshes"][0]["primitives"][0]["attributes"]["TANGENT"] =
        builder.addAccessor(std::vector<float>{0, 2, 0, -1, 0, 2, 0, -1, 0, 2, 0, -1, 0, 2, 0, -1}, FLOAT, "VEC4");
    EXPECT_EQ(load(builder).attributes[0].tangent, glm::vec4(0, 1, 0, -1));
}
