#include "scene/lights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace restirpg {

namespace {

constexpr double PI = std::numbers::pi;

/// Points per side of the grid that averages a textured emitter: one a texel, within these.
constexpr int FEWEST_GRID_POINTS = 4;
constexpr int MOST_GRID_POINTS = 64;

double luminance(glm::dvec3 rgb)
{
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Mean of a texture over a triangle, at the centres of the small triangles that a regular barycentric grid cuts it
/// into.
glm::dvec3 textureMean(const Texture& texture, const std::array<glm::vec2, 3>& uv)
{
    float longest = 0;
    for (size_t i = 0; i < 3; ++i)
        longest = std::max(longest, glm::length((uv[(i + 1) % 3] - uv[i]) * glm::vec2(texture.width, texture.height)));
    const int n = int(std::clamp(std::ceil(longest), float(FEWEST_GRID_POINTS), float(MOST_GRID_POINTS)));
    glm::dvec3 sum(0);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < 2 * (n - i) - 1; ++j) {
            // Even j: an upright cell; odd j: the inverted one beside it.
            const float third = j % 2 ? 2.0f / 3 : 1.0f / 3;
            const float b1 = (float(i) + third) / float(n), b2 = (float(j / 2) + third) / float(n);
            sum += glm::dvec3(texture.sample(uv[0] * (1 - b1 - b2) + uv[1] * b1 + uv[2] * b2));
        }
    return sum / double(n * n);
}

/// Mean radiance that a triangle emits, before its area.
glm::dvec3 meanEmission(const Scene& scene, const Material& material, const SceneMesh& mesh, const glm::uvec3& triangle)
{
    const auto& map = material.emissiveMap;
    if (map.index == INVALID_INDEX)
        return material.emission;
    std::array<glm::vec2, 3> uv;
    for (int i = 0; i < 3; ++i) {
        const auto& vertex = scene.attributes[mesh.firstVertex + triangle[i]];
        const glm::vec3 point(map.uvSet == 0 ? vertex.uv0 : vertex.uv1, 1);
        uv[size_t(i)] = {glm::dot(map.row0, point), glm::dot(map.row1, point)};
    }
    return glm::dvec3(material.emission) * textureMean(scene.textures[map.index], uv);
}

double worldArea(const Scene& scene, const SceneMesh& mesh, const glm::uvec3& triangle, const glm::mat4& pose)
{
    std::array<glm::dvec3, 3> p;
    for (int i = 0; i < 3; ++i)
        p[size_t(i)] = glm::dvec3(pose * glm::vec4(scene.positions[mesh.firstVertex + triangle[i]], 1));
    return 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

/// Place and direction of a punctual light at its node's pose.
void placePunctual(Light& light, const glm::mat4& pose)
{
    const auto forward = -glm::vec3(pose[2]);
    const float length = glm::length(forward);
    light.position = glm::vec3(pose[3]);
    light.direction = length > 0 ? forward / length : glm::vec3(0, 0, -1);
}

Light emptyLight(uint32_t type)
{
    Light light{};
    light.type = type;
    light.instance = INVALID_INDEX;
    light.triangle = INVALID_INDEX;
    light.direction = glm::vec3(0, 0, -1);
    return light;
}

/// Collects lights and their powers in watts.
class LightCollector {
public:
    LightCollector(const Scene& scene, const std::vector<glm::mat4>& pose, double radius)
        : scene_(scene), pose_(pose), disk_(PI * radius * radius) {}

    LightTable collect()
    {
        for (uint32_t i = 0; i < scene_.instances.size(); ++i)
            addInstance(i);
        for (const auto& source : scene_.punctualLights)
            addPunctual(source);
        if (scene_.environment)
            addEnvironment(*scene_.environment);
        if (!powers_.empty()) {
            std::vector<float> pmf;
            const auto columns = buildAliasTable(powers_, pmf);
            for (size_t i = 0; i < columns.size(); ++i) {
                table_.lights[i].pmf = pmf[i];
                table_.lights[i].aliasThreshold = columns[i].threshold;
                table_.lights[i].alias = columns[i].alias;
            }
        }
        return std::move(table_);
    }

private:
    /// Index of the light, or INVALID_INDEX where it has no power.
    uint32_t add(const Light& light, double power)
    {
        if (!(power > 0) || !std::isfinite(power))
            return INVALID_INDEX;
        table_.lights.push_back(light);
        powers_.push_back(power);
        return uint32_t(table_.lights.size() - 1);
    }

    void addInstance(uint32_t instance)
    {
        const auto& mesh = scene_.meshes[scene_.instances[instance].mesh];
        const auto& pose = pose_[scene_.instances[instance].node];
        std::vector<uint32_t> lights(mesh.triangleCount, INVALID_INDEX);
        for (uint32_t t = 0; t < mesh.triangleCount; ++t) {
            const auto& material = scene_.materials[scene_.materialOfTriangle[mesh.firstTriangle + t]];
            if (!(material.flags & MATERIAL_EMISSIVE))
                continue;
            const auto& triangle = scene_.triangles[mesh.firstTriangle + t];
            const int sides = material.flags & MATERIAL_DOUBLE_SIDED ? 2 : 1;
            auto light = emptyLight(LIGHT_TRIANGLE);
            light.instance = instance;
            light.triangle = t;
            lights[t] = add(light, PI * sides * worldArea(scene_, mesh, triangle, pose)
                                       * luminance(meanEmission(scene_, material, mesh, triangle)));
        }
        const bool emits =
            std::any_of(lights.begin(), lights.end(), [](uint32_t light) { return light != INVALID_INDEX; });
        table_.lightMapOfInstance.push_back(emits ? uint32_t(table_.lightOfTriangle.size()) : INVALID_INDEX);
        if (emits)
            table_.lightOfTriangle.insert(table_.lightOfTriangle.end(), lights.begin(), lights.end());
    }

    void addPunctual(const PunctualLight& source)
    {
        auto light = emptyLight(source.type);
        light.intensity = source.intensity;
        light.cosInner = std::cos(source.innerCone);
        light.cosOuter = std::cos(source.outerCone);
        placePunctual(light, pose_[source.node]);
        table_.punctualLights.push_back(add(light, power(light)));
    }

    double power(const Light& light) const
    {
        const double intensity = luminance(light.intensity);
        switch (light.type) {
        case LIGHT_POINT: return 4 * PI * intensity;
        case LIGHT_SPOT: return 2 * PI * (1 - light.cosOuter) * intensity;
        default: return disk_ * intensity;
        }
    }

    void addEnvironment(const Environment& environment)
    {
        double integral = 4 * PI * luminance(environment.radiance);
        if (environment.texture)
            integral = addEnvironmentCells(*environment.texture) * luminance(environment.radiance);
        table_.environmentLight = add(emptyLight(LIGHT_ENVIRONMENT), disk_ * integral);
        if (table_.environmentLight == INVALID_INDEX)
            table_.environmentCells.clear();
    }

    /// Fill the cells; the integral of the texture's luminance over the sphere.
    double addEnvironmentCells(const Texture& texture)
    {
        const int width = int(texture.width), height = int(texture.height);
        std::vector<double> texels(size_t(width) * size_t(height)), weights(texels.size());
        for (size_t i = 0; i < texels.size(); ++i)
            texels[i] = luminance({texture.floats[4 * i], texture.floats[4 * i + 1], texture.floats[4 * i + 2]});
        double integral = 0;
        for (int y = 0; y < height; ++y) {
            const double solidAngle = 2 * PI / width * (std::cos(PI * y / height) - std::cos(PI * (y + 1) / height));
            for (int x = 0; x < width; ++x) {
                const size_t texel = size_t(y) * size_t(width) + size_t(x);
                integral += texels[texel] * solidAngle;
                weights[texel] = neighbourhoodMean(texels, width, height, x, y) * solidAngle;
            }
        }
        if (!(integral > 0))
            return 0;
        std::vector<float> pmf;
        const auto columns = buildAliasTable(weights, pmf);
        table_.environmentCells.resize(columns.size());
        for (size_t i = 0; i < columns.size(); ++i)
            table_.environmentCells[i] = {float(double(pmf[i]) * double(columns.size())), columns[i].threshold,
                                          columns[i].alias};
        return integral;
    }

    /// Mean over 3 x 3 texels: a bilinear lookup inside a texel reads no others, so that the pdf is positive where
    /// radiance is.
    static double neighbourhoodMean(const std::vector<double>& texels, int width, int height, int x, int y)
    {
        double sum = 0;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx)
                sum += texels[size_t(std::clamp(y + dy, 0, height - 1)) * size_t(width) +
                              size_t((x + dx + width) % width)];
        return sum / 9;
    }

    const Scene& scene_;
    const std::vector<glm::mat4>& pose_;
    double disk_;  ///< area of the scene's cross-section, m^2
    LightTable table_;
    std::vector<double> powers_;
};

}  // namespace

LightTable buildLightTable(const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius)
{
    return LightCollector(scene, pose, sceneRadius).collect();
}

void moveLights(LightTable& table, const Scene& scene, const std::vector<glm::mat4>& pose)
{
    for (size_t i = 0; i < table.punctualLights.size(); ++i)
        if (table.punctualLights[i] != INVALID_INDEX)
            placePunctual(table.lights[table.punctualLights[i]], pose[scene.punctualLights[i].node]);
}

}  // namespace restirpg
