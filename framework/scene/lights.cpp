#include "scene/lights.h"

#include "scene/emission.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace restirpg {

namespace {

constexpr double PI = std::numbers::pi;

double worldArea(const Scene& scene, const SceneMesh& mesh, uint32_t triangle, const glm::mat4& pose)
{
    const auto& corners = scene.triangles[mesh.firstTriangle + triangle];
    std::array<glm::dvec3, 3> p;
    for (int i = 0; i < 3; ++i)
        p[size_t(i)] = glm::dvec3(pose * glm::vec4(scene.positions[mesh.firstVertex + corners[i]], 1));
    return 0.5 * glm::length(glm::cross(p[1] - p[0], p[2] - p[0]));
}

/// The metric that an instance's matrix gives to its mesh.
glm::mat3 metricOf(const glm::mat4& pose)
{
    const glm::mat3 linear(pose);
    return glm::transpose(linear) * linear;
}

/// Do two metrics give the same areas, but for what rounding makes of a rotation?
bool sameMetric(const glm::mat3& a, const glm::mat3& b)
{
    constexpr float ROUNDING = 1e-5f;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(a[i][j] - b[i][j]) <=
                  ROUNDING * std::sqrt(std::min(a[i][i], b[i][i]) * std::min(a[j][j], b[j][j]))))
                return false;
    return true;
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
    light.cells = INVALID_INDEX;
    light.direction = glm::vec3(0, 0, -1);
    return light;
}

/// A cell of an alias table for each weight.
std::vector<ImportanceCell> makeCells(std::span<const double> weights)
{
    std::vector<float> pmf;
    const auto columns = buildAliasTable(weights, pmf);
    std::vector<ImportanceCell> cells;
    for (size_t i = 0; i < columns.size(); ++i)
        cells.push_back({float(double(pmf[i]) * double(columns.size())), columns[i].threshold, columns[i].alias});
    return cells;
}

/// Collects lights and their strengths.
class LightCollector {
public:
    explicit LightCollector(const Scene& scene) : scene_(scene), emission_(measureEmission(scene)) {}

    LightTable collect()
    {
        for (const auto& [triangle, parts] : emission_.parts) {
            firstCell_[triangle] = uint32_t(table_.emissionCells.size());
            const auto cells = makeCells(parts.luminances);
            table_.emissionCells.insert(table_.emissionCells.end(), cells.begin(), cells.end());
        }
        for (uint32_t i = 0; i < scene_.instances.size(); ++i)
            addInstance(i);
        for (const auto& source : scene_.punctualLights)
            addPunctual(source);
        if (scene_.environment)
            addEnvironment(*scene_.environment);
        return std::move(table_);
    }

private:
    /// Index of the light, or INVALID_INDEX where it is dark.
    uint32_t add(const Light& light, double strength)
    {
        if (!(strength > 0) || !std::isfinite(strength))
            return INVALID_INDEX;
        table_.lights.push_back(light);
        table_.strengths.push_back(strength);
        return uint32_t(table_.lights.size() - 1);
    }

    void addInstance(uint32_t instance)
    {
        const auto& mesh = scene_.meshes[scene_.instances[instance].mesh];
        const auto first = emission_.mean.begin() + mesh.firstTriangle;
        table_.lightMapOfInstance.push_back(INVALID_INDEX);
        if (std::none_of(first, first + mesh.triangleCount, [](double mean) { return mean > 0; }))
            return;
        table_.lightMapOfInstance.back() = uint32_t(table_.lightOfTriangle.size());
        for (uint32_t t = 0; t < mesh.triangleCount; ++t)
            table_.lightOfTriangle.push_back(addTriangle(instance, t, mesh.firstTriangle + t));
    }

    uint32_t addTriangle(uint32_t instance, uint32_t triangle, uint32_t sceneTriangle)
    {
        const auto& material = scene_.materials[scene_.materialOfTriangle[sceneTriangle]];
        auto light = emptyLight(LIGHT_TRIANGLE);
        light.instance = instance;
        light.triangle = triangle;
        if (const auto parts = emission_.parts.find(sceneTriangle); parts != emission_.parts.end()) {
            light.cells = firstCell_[sceneTriangle];
            light.cellsASide = parts->second.side;
        }
        const int sides = material.flags & MATERIAL_DOUBLE_SIDED ? 2 : 1;
        return add(light, PI * sides * emission_.mean[sceneTriangle]);
    }

    void addPunctual(const PunctualLight& source)
    {
        auto light = emptyLight(source.type);
        light.intensity = source.intensity;
        light.cosInner = std::cos(source.innerCone);
        light.cosOuter = std::cos(source.outerCone);
        const double intensity = luminance(light.intensity);
        const double solidAngle = source.type == LIGHT_POINT  ? 4 * PI
                                  : source.type == LIGHT_SPOT ? 2 * PI * (1 - light.cosOuter)
                                                              : 1;  // a directional light's irradiance
        table_.punctualLights.push_back(add(light, solidAngle * intensity));
    }

    void addEnvironment(const Environment& environment)
    {
        double integral = 4 * PI * luminance(environment.radiance);
        if (environment.texture)
            integral = addEnvironmentCells(*environment.texture) * luminance(environment.radiance);
        table_.environmentLight = add(emptyLight(LIGHT_ENVIRONMENT), integral);
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
        table_.environmentCells = makeCells(weights);
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
    Emission emission_;
    std::map<uint32_t, uint32_t> firstCell_;  ///< of a triangle's parts, in the table
    LightTable table_;
};

/// The factor from a light's strength to its power; `disk`: area of the scene's cross-section, m^2.
double extentOf(const Light& light, const Scene& scene, const std::vector<glm::mat4>& pose, double disk)
{
    switch (light.type) {
    case LIGHT_TRIANGLE: {
        const auto& instance = scene.instances[light.instance];
        return worldArea(scene, scene.meshes[instance.mesh], light.triangle, pose[instance.node]);
    }
    case LIGHT_DIRECTIONAL:
    case LIGHT_ENVIRONMENT:
        return disk;
    default:
        return 1;
    }
}

/// Note every instance's metric; which ones have changed?
std::vector<bool> updateMetrics(LightTable& table, const Scene& scene, const std::vector<glm::mat4>& pose)
{
    std::vector<bool> changed(scene.instances.size());
    table.metricOfInstance.resize(scene.instances.size(), glm::mat3(-1));  // no matrix has this metric
    for (size_t i = 0; i < changed.size(); ++i) {
        const auto metric = metricOf(pose[scene.instances[i].node]);
        changed[i] = !sameMetric(metric, table.metricOfInstance[i]);
        if (changed[i])
            table.metricOfInstance[i] = metric;
    }
    return changed;
}

void selectByPower(LightTable& table)
{
    table.lit = std::any_of(table.powers.begin(), table.powers.end(), [](double power) { return power > 0; });
    if (!table.lit) {
        for (auto& light : table.lights)
            light.pmf = 0;
        return;
    }
    std::vector<float> pmf;
    const auto columns = buildAliasTable(table.powers, pmf);
    for (size_t i = 0; i < columns.size(); ++i) {
        table.lights[i].pmf = pmf[i];
        table.lights[i].aliasThreshold = columns[i].threshold;
        table.lights[i].alias = columns[i].alias;
    }
}

}  // namespace

LightTable buildLightTable(const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius)
{
    auto table = LightCollector(scene).collect();
    moveLights(table, scene, pose, sceneRadius);
    return table;
}

void moveLights(LightTable& table, const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius)
{
    for (size_t i = 0; i < table.punctualLights.size(); ++i)
        if (table.punctualLights[i] != INVALID_INDEX)
            placePunctual(table.lights[table.punctualLights[i]], pose[scene.punctualLights[i].node]);

    const double disk = PI * double(sceneRadius) * double(sceneRadius);
    const auto reshaped = updateMetrics(table, scene, pose);
    auto powers = table.powers;
    powers.resize(table.lights.size());
    for (size_t i = 0; i < powers.size(); ++i) {
        const auto& light = table.lights[i];
        if (light.type == LIGHT_TRIANGLE && !reshaped[light.instance])
            continue;
        const double power = table.strengths[i] * extentOf(light, scene, pose, disk);
        powers[i] = std::isfinite(power) ? power : 0;
    }
    if (powers == table.powers)
        return;
    table.powers = std::move(powers);
    selectByPower(table);
}

}  // namespace restirpg
