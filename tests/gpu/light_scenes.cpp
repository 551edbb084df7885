#include "light_scenes.h"

#include "gpu_test.h"

#include <glm/gtc/matrix_transform.hpp>

#include <cmath>

namespace restirpg::test {
namespace {

TextureRef noTexture()
{
    return {{1, 0, 0}, {0, 1, 0}, INVALID_INDEX, 0};
}

Material emitter(const glm::vec3& radiance, uint32_t flags)
{
    Material material{};
    material.baseColor = glm::vec3(0.5f);
    material.emission = radiance;
    material.roughness = 1;
    material.ior = 1.5f;
    material.alpha = 1;
    material.alphaCutoff = 0.5f;
    material.flags = flags;
    for (TextureRef* map :
         {&material.baseColorMap, &material.metallicRoughnessMap, &material.normalMap, &material.emissiveMap,
          &material.transmissionMap, &material.specularMap, &material.specularColorMap})
        *map = noTexture();
    return material;
}

/// A mesh of one triangle for each material.
void addTriangles(Scene& scene, const std::vector<std::array<glm::vec3, 3>>& triangles)
{
    SceneMesh mesh;
    mesh.name = "triangles";
    mesh.vertexCount = uint32_t(3 * triangles.size());
    mesh.triangleCount = uint32_t(triangles.size());
    for (uint32_t index = 0; index < triangles.size(); ++index) {
        const auto& corners = triangles[index];
        const glm::vec3 normal = glm::normalize(glm::cross(corners[1] - corners[0], corners[2] - corners[0]));
        const std::array<glm::vec2, 3> uvs{glm::vec2(0.1f, 0.1f), {0.9f, 0.2f}, {0.3f, 0.8f}};
        for (int corner = 0; corner < 3; ++corner) {
            scene.positions.push_back(corners[size_t(corner)]);
            scene.attributes.push_back({normal, glm::vec4(0), uvs[size_t(corner)], uvs[size_t(corner)], glm::vec4(1)});
        }
        scene.triangles.emplace_back(3 * index, 3 * index + 1, 3 * index + 2);
        scene.materialOfTriangle.push_back(index);
    }
    scene.meshes.push_back(mesh);
}

void addNode(Scene& scene, const glm::mat4& matrix)
{
    Node node;
    node.matrix = matrix;
    scene.nodes.push_back(node);
}

void addInstance(Scene& scene, const glm::mat4& matrix)
{
    addNode(scene, matrix);
    scene.instances.push_back({0, uint32_t(scene.nodes.size() - 1)});
}

/// Radiance and coverage that vary over the texture.
Texture pattern()
{
    Texture texture;
    texture.name = "pattern";
    texture.width = texture.height = 8;
    for (uint32_t y = 0; y < 8; ++y)
        for (uint32_t x = 0; x < 8; ++x)
            for (float value : {0.1f + 0.1f * float(x), 0.5f, 0.9f - 0.1f * float(y), (x + y) % 4 < 2 ? 1.0f : 0.0f})
                texture.floats.push_back(value);
    return texture;
}

}  // namespace

Scene triangleLightScene()
{
    Scene scene;
    scene.textures.push_back(pattern());
    Material textured = emitter({8, 2, 4}, MATERIAL_EMISSIVE | MATERIAL_DOUBLE_SIDED);
    textured.emissiveMap.index = 0;
    Material masked = emitter({5, 5, 5}, MATERIAL_EMISSIVE | MATERIAL_DOUBLE_SIDED | MATERIAL_ALPHA_MASK);
    masked.baseColorMap.index = 0;
    scene.materials = {emitter({1, 2, 3}, MATERIAL_EMISSIVE),
                       emitter({4, 1, 1}, MATERIAL_EMISSIVE | MATERIAL_DOUBLE_SIDED), textured, masked,
                       emitter({0, 0, 0}, 0)};
    addTriangles(scene, {{{{-1, -1, 2}, {0, 1, 2}, {1, -1, 2.5f}}},
                         {{{2, -1, -1}, {2, 1, 0}, {1.5f, -1, 1}}},
                         {{{-2, 1, -1}, {-1, 2, 1}, {-2, 0, 1.5f}}},
                         {{{-1, -2, 1}, {1, -2, 0}, {0, -1.5f, -1}}},
                         {{{0.5f, 2, 0}, {1, 2, 0}, {0.5f, 2, 0.5f}}}});
    addInstance(scene, glm::mat4(1));
    glm::mat4 sheared =
        glm::scale(glm::rotate(glm::translate(glm::mat4(1), {0.3f, 0.2f, -1}), 1.1f, {0.6f, 0, 0.8f}), {0.5f, 2, 1.2f});
    sheared[1][0] += 0.4f;
    addInstance(scene, sheared);
    addInstance(scene, glm::scale(glm::rotate(glm::mat4(1), 2.0f, {0, 1, 0}), {-1.5f, 1.5f, 1.5f}));
    return scene;
}

Scene signScene()
{
    using Wrap = Texture::Wrap;
    Scene scene;
    Texture sign;
    sign.name = "sign";
    sign.width = 12;
    sign.height = 6;
    sign.srgb = true;
    for (uint32_t i = 0; i < sign.width * sign.height; ++i) {
        const uint8_t level = i % 12 == 3 ? 255 : i == 40 ? 230 : 0;
        sign.bytes.insert(sign.bytes.end(), {level, uint8_t(level / 2), level, 255});
    }
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge}) {
        sign.wrapU = sign.wrapV = wrap;
        sign.filter = wrap == Wrap::repeat ? Texture::Filter::nearest : Texture::Filter::linear;
        Material material = emitter({3, 2, 1}, MATERIAL_EMISSIVE | MATERIAL_DOUBLE_SIDED);
        material.emissiveMap = {{2.0f, 0.3f, -0.4f}, {-0.2f, 1.5f, -0.3f}, uint32_t(scene.textures.size()), 0};
        scene.textures.push_back(sign);
        scene.materials.push_back(material);
    }
    addTriangles(scene, {{{{-2, -2, 2}, {0, 2, 2}, {2, -2, 2.5f}}},
                         {{{3, -2, -2}, {3, 2, 0}, {2.5f, -2, 2}}},
                         {{{-3, 1, -2}, {-1, 3, 1}, {-3, -1, 2.5f}}}});
    addInstance(scene, glm::mat4(1));
    return scene;
}

Scene darkScene()
{
    Scene scene;
    scene.materials = {emitter({0, 0, 0}, 0)};
    addTriangles(scene, {{{{10, 10, 10}, {11, 10, 10}, {10, 11, 10}}}});
    addInstance(scene, glm::mat4(1));
    return scene;
}

Environment sunnySky()
{
    Environment environment;
    environment.radiance = glm::vec3(1, 0.9f, 0.8f);
    environment.rotation = 0.7f;
    Texture& sky = environment.texture.emplace();
    sky.name = "sky";
    sky.width = 64;
    sky.height = 32;
    sky.wrapV = Texture::Wrap::clampToEdge;
    for (uint32_t y = 0; y < sky.height; ++y)
        for (uint32_t x = 0; x < sky.width; ++x) {
            const bool sun = x >= 20 && x < 23 && y >= 13 && y < 15;
            const float value = sun ? 300.0f : y < 20 ? 0.2f + 0.05f * float(y) : 0.0f;
            sky.floats.insert(sky.floats.end(), {value, value, value, 1});
        }
    return environment;
}

void addPunctualLights(Scene& scene)
{
    const glm::mat4 down = glm::rotate(glm::translate(glm::mat4(1), {0.5f, 3, 0}), -1.2f, {1, 0, 0});
    for (const uint32_t type : {LIGHT_POINT, LIGHT_SPOT, LIGHT_DIRECTIONAL}) {
        addNode(scene, down);
        PunctualLight light;
        light.node = uint32_t(scene.nodes.size() - 1);
        light.type = type;
        light.intensity = {1, 2, 3};
        light.innerCone = 0.34906585f;
        light.outerCone = 0.7853982f;
        scene.punctualLights.push_back(light);
    }
}

UploadedScene::UploadedScene(Scene source) : scene(std::move(source)), gpu(device(), scene, poseNodes(scene, 0))
{
    FrameConstants constants{};
    constants.scene = gpu.table();
    frame = device().createBuffer(std::vector<FrameConstants>{constants}, "frame");
}

}  // namespace restirpg::test
