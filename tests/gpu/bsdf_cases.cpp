#include "bsdf_cases.h"

#include <cmath>
#include <stdexcept>

namespace restirpg::test {

double dielectricFresnel(double cosine, double eta)
{
    const double sine = std::sqrt(1 - cosine * cosine) / eta;
    if (sine >= 1)
        return 1;
    const double theta = std::acos(cosine);
    const double transmitted = std::asin(sine);
    if (theta < 1e-6)
        return std::pow((eta - 1) / (eta + 1), 2);
    // Fresnel's sine and tangent laws.
    const double s = std::sin(theta - transmitted) / std::sin(theta + transmitted);
    const double p = std::tan(theta - transmitted) / std::tan(theta + transmitted);
    return 0.5 * (s * s + p * p);
}

double coatAverage(double ior)
{
    if (ior == 0)
        return 1.0 / 21;  // Schlick's (1 - cos)^5, which total reflection has
    const double f0 = dielectricFresnel(1, ior);
    if (ior == 1)
        return 0;
    double sum = 0;
    constexpr int STEPS = 20000;
    for (int step = 0; step < STEPS; ++step) {
        const double cosine = (step + 0.5) / STEPS;
        sum += 2 * cosine * (dielectricFresnel(cosine, ior) - f0) / (1 - f0) / STEPS;
    }
    return sum;
}

namespace {

struct Look {
    glm::vec3 color{1};
    float metallic = 0;
    float roughness = 0.5f;
    float specular = 1;
    glm::vec3 specularColor{1};
    float transmission = 0;
    float ior = 1.5f;
    bool solid = false;
    bool entering = true;
};

NamedMaterial make(const std::string& name, const Look& look)
{
    NamedMaterial made{name, {}, {}};
    BsdfCase& m = made.material;
    m.baseColor = look.color;
    m.metallic = look.metallic;
    m.roughness = look.roughness;
    m.specular = look.specular;
    m.specularColor = look.specularColor;
    m.transmission = look.transmission;
    m.ior = look.ior;
    m.coatAverage = float(coatAverage(look.ior));
    m.solid = look.solid;
    m.entering = look.entering;
    if (look.metallic < 1 && look.transmission < 1 && (look.entering || !look.solid))
        made.lobes.push_back(LOBE_DIFFUSE);
    if (look.metallic > 0 || look.specular > 0)
        made.lobes.push_back(LOBE_REFLECT);
    if (look.metallic < 1 && look.transmission > 0)
        made.lobes.push_back(LOBE_TRANSMIT);
    return made;
}

}  // namespace

const std::vector<NamedMaterial>& materials()
{
    static const glm::vec3 RED(0.8f, 0.2f, 0.1f), GOLD(1.0f, 0.78f, 0.34f), GREEN(0.5f, 0.9f, 0.6f);
    static const std::vector<NamedMaterial> all{
        make("lambert", {.color = RED, .roughness = 1, .specular = 0}),
        make("rough plastic", {.color = RED, .roughness = 0.6f}),
        make("glossy plastic", {.color = RED, .roughness = 0.15f}),
        make("smooth plastic", {.roughness = 0}),
        make("plastic under a red coat", {.roughness = 0.3f, .specularColor = {20, 1, 1}}),
        make("gold", {.color = GOLD, .metallic = 1, .roughness = 0.3f}),
        make("polished metal", {.metallic = 1, .roughness = 0.04f}),
        make("roughest metal", {.metallic = 1, .roughness = 1}),
        make("half metal", {.color = GOLD, .metallic = 0.5f, .roughness = 0.4f}),
        make("frosted glass", {.roughness = 0.6f, .transmission = 1, .solid = true}),
        make("frosted glass from inside", {.roughness = 0.6f, .transmission = 1, .solid = true, .entering = false}),
        make("sharp dense glass",
             {.color = GREEN, .roughness = 0.1f, .transmission = 1, .ior = 1.9f, .solid = true, .entering = false}),
        make("tinted thin sheet", {.color = GREEN, .roughness = 0.35f, .transmission = 1}),
        make("milky glass", {.color = GREEN,
                             .roughness = 0.6f,
                             .specular = 0.7f,
                             .specularColor = GOLD,
                             .transmission = 0.5f,
                             .solid = true}),
        make("milky glass from inside",
             {.color = GREEN, .roughness = 0.6f, .transmission = 0.5f, .solid = true, .entering = false}),
        make("painted glass from inside", {.color = GREEN, .roughness = 0.3f, .solid = true, .entering = false}),
        make("smooth glass", {.roughness = 0, .transmission = 1, .solid = true}),
        make("smooth glass from inside", {.roughness = 0, .transmission = 1, .solid = true, .entering = false}),
        make("smooth thin sheet", {.roughness = 0, .transmission = 1}),
    };
    return all;
}

const BsdfCase& material(const std::string& name)
{
    for (const NamedMaterial& candidate : materials())
        if (candidate.name == name)
            return candidate.material;
    throw std::logic_error("no test material " + name);
}

const std::vector<glm::vec3>& directions()
{
    static const std::vector<glm::vec3> all = [] {
        std::vector<glm::vec3> made;
        float azimuth = 0;
        for (float cosine : {1.0f, 0.8f, 0.5f, 0.15f, 0.01f}) {
            const float sine = std::sqrt(1 - cosine * cosine);
            made.emplace_back(sine * std::cos(azimuth), sine * std::sin(azimuth), cosine);
            azimuth += 1.3f;
        }
        return made;
    }();
    return all;
}

}  // namespace restirpg::test
