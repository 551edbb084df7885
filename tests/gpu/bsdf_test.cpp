// What the BSDF is: against the textbook in double precision, classes of lobes, reciprocity.
#include "bsdf_measure.h"
#include "extremes_case.h"

#include <bit>
#include <cmath>
#include <random>

namespace restirpg::test {
namespace {

using glm::dvec3;

constexpr double PI = 3.14159265358979;

std::vector<BsdfValues> evaluate(BsdfCase test, const std::vector<DirectionPair>& pairs)
{
    const Buffer inputs = device().createBuffer(pairs, "pairs");
    const Buffer results = device().createBuffer(pairs.size() * sizeof(BsdfValues), "values");
    test.inputs = inputs.address();
    test.results = results.address();
    run("bsdf_values", test, uint32_t(pairs.size()));
    return device().download<BsdfValues>(results, uint32_t(pairs.size()));
}

/// Pairs of directions: wo above, wi anywhere, neither closer than 0.6 degrees to the horizon. A multiple of 64.
std::vector<DirectionPair> randomPairs()
{
    std::mt19937 generator(7);
    std::uniform_real_distribution<float> uniform;
    const auto direction = [&](float lowest) {
        float z = 0;
        while (std::abs(z) < 0.01f)
            z = lowest + (1 - lowest) * uniform(generator);
        const float phi = 6.2831853f * uniform(generator), r = std::sqrt(1 - z * z);
        return glm::vec3(r * std::cos(phi), r * std::sin(phi), z);
    };
    std::vector<DirectionPair> pairs(4096);
    for (DirectionPair& pair : pairs)
        pair = {direction(0), direction(-1)};
    return pairs;
}

// ---- The textbook, written from the papers: slopes and Lambda functions instead of the shader's cancelled forms ----

double smithLambda(const dvec3& w, double alpha)
{
    const double tangent2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    return 0.5 * (std::sqrt(1 + alpha * alpha * tangent2) - 1);
}

double ggxDistribution(const dvec3& h, double alpha)
{
    const double c2 = h.z * h.z;
    const double tangent2 = (1 - c2) / c2;
    return alpha * alpha / (PI * c2 * c2 * std::pow(alpha * alpha + tangent2, 2));
}

/// F of the dielectric under KHR_materials_specular, and of a thin pane of it.
dvec3 textbookCoat(const BsdfCase& m, double cosine, double eta)
{
    if (m.solid && eta < 1 && dielectricFresnel(cosine, eta) >= 1)
        return dvec3(1);  // total internal reflection
    const double f0 = dielectricFresnel(1, m.ior);
    const double s = (dielectricFresnel(cosine, eta) - f0) / (1 - f0);
    const dvec3 coat0 = glm::min(f0 * dvec3(m.specularColor), dvec3(1));
    return double(m.specular) * glm::mix(coat0, dvec3(1), s);
}

/// What it takes of the light towards what lies below it: the largest channel of KHR_materials_specular's Fresnel term.
double textbookCoatShare(const BsdfCase& m, double cosine, double eta)
{
    const dvec3 coat = textbookCoat(m, cosine, eta);
    return std::max({coat.r, coat.g, coat.b});
}

dvec3 textbookReflection(const BsdfCase& m, const dvec3& wo, const dvec3& wi, double eta)
{
    const double alpha = double(m.roughness) * m.roughness;
    const dvec3 h = glm::normalize(wo + wi);
    const double cosine = glm::dot(wo, h);
    const dvec3 coat = textbookCoat(m, cosine, eta);
    const dvec3 dielectric = m.solid ? coat : glm::mix(coat, 2.0 * coat / (1.0 + coat), double(m.transmission));
    const dvec3 metal = dvec3(m.baseColor) + (1.0 - dvec3(m.baseColor)) * std::pow(1 - cosine, 5);
    const double g = 1 / (1 + smithLambda(wo, alpha) + smithLambda(wi, alpha));
    return glm::mix(dielectric, metal, double(m.metallic)) * (ggxDistribution(h, alpha) * g / (4 * wo.z * wi.z));
}

dvec3 textbookTransmission(const BsdfCase& m, const dvec3& wo, const dvec3& wi, double eta)
{
    const double alpha = double(m.roughness) * m.roughness;
    const dvec3 base = (1.0 - m.metallic) * m.transmission * dvec3(m.baseColor);
    const double g = 1 / (1 + smithLambda(wo, alpha) + smithLambda(wi, alpha));
    if (!m.solid) {
        const dvec3 h = glm::normalize(wo + dvec3(wi.x, wi.y, -wi.z));
        const double coat = textbookCoatShare(m, glm::dot(wo, h), eta);
        return base * (1.0 - 2.0 * coat / (1.0 + coat)) * (ggxDistribution(h, alpha) * g / (4 * wo.z * -wi.z));
    }
    dvec3 h = glm::normalize(wo + eta * wi);
    h = h.z < 0 ? -h : h;
    const double o = glm::dot(wo, h), i = glm::dot(wi, h);
    if (o <= 0 || i >= 0 || dielectricFresnel(o, eta) >= 1)
        return dvec3(0);
    return base * (1.0 - textbookCoatShare(m, o, eta)) * std::abs(o * i / (wo.z * wi.z)) * ggxDistribution(h, alpha) *
           g / std::pow(o + eta * i, 2);
}

/// The shader's fit; EnergyOfWhitePaintUnderARoughCoat tests it against the lobe itself.
double coatCosine(double cosine, double alpha)
{
    const double grazing = 0.511 * alpha / (0.228 + alpha);
    const double normal = 1 - 0.293 * alpha / (0.816 + alpha);
    const double linear = 1.222 * alpha * alpha;
    return std::sqrt(grazing * grazing + linear * cosine +
                     (normal * normal - grazing * grazing - linear) * cosine * cosine);
}

dvec3 textbookDiffuse(const BsdfCase& m, const dvec3& wo, const dvec3& wi, double eta)
{
    if (m.solid && !m.entering)
        return dvec3(0);
    const double alpha = m.roughness < DELTA_ROUGHNESS ? 0 : double(m.roughness) * m.roughness;
    const double position = m.coatAverage / (1 + 2.6 * alpha + 12.4 * alpha * alpha);
    const double f0 = dielectricFresnel(1, m.ior);
    const double color = std::max({m.specularColor.r, m.specularColor.g, m.specularColor.b});
    const double coat0 = std::min(f0 * color, 1.0);
    const double average = double(m.specular) * glm::mix(coat0, 1.0, position);
    return (1.0 - m.metallic) * (1.0 - m.transmission) * dvec3(m.baseColor) / PI *
           (1.0 - textbookCoatShare(m, coatCosine(wo.z, alpha), eta)) *
           (1.0 - textbookCoatShare(m, coatCosine(wi.z, alpha), eta)) / (1.0 - average);
}

dvec3 textbookBsdf(const BsdfCase& m, const dvec3& wo, const dvec3& wi, bool rough)
{
    const double eta = m.solid && !m.entering ? 1.0 / m.ior : m.ior;
    if (wi.z < 0)
        return rough ? textbookTransmission(m, wo, wi, eta) : dvec3(0);
    return textbookDiffuse(m, wo, wi, eta) + (rough ? textbookReflection(m, wo, wi, eta) : dvec3(0));
}

TEST(Bsdf, MatchesTheTextbookInDoublePrecision)
{
    const auto pairs = randomPairs();
    for (const NamedMaterial& entry : materials()) {
        BsdfCase test = entry.material;
        test.lobe = LOBE_ALL;
        const auto values = evaluate(test, pairs);
        for (size_t index = 0; index < pairs.size(); ++index) {
            const dvec3 expected =
                textbookBsdf(test, pairs[index].wo, pairs[index].wi, test.roughness >= DELTA_ROUGHNESS);
            for (int channel = 0; channel < 3; ++channel)
                ASSERT_NEAR(values[index].f[channel], expected[channel], 1e-6 + 2e-3 * expected[channel])
                    << entry.name << ", pair " << index << ", wo.z " << pairs[index].wo.z << ", wi.z "
                    << pairs[index].wi.z;
        }
    }
}

TEST(Bsdf, ThePdfIsTheSumOfItsLobes)
{
    const auto pairs = randomPairs();
    for (const NamedMaterial& entry : materials()) {
        BsdfCase test = entry.material;
        for (uint32_t mask = 1; mask <= LOBE_ALL; ++mask) {
            test.lobe = mask;
            for (const BsdfValues& value : evaluate(test, pairs))
                ASSERT_NEAR(value.pdf, value.pdfSum, 1e-5 * (1 + value.pdf)) << entry.name << ", lobes " << mask;
        }
    }
}

TEST(Bsdf, LobeProbabilitiesSumToOneCoverRoughLobesAndLeaveOutAbsentOnes)
{
    const auto pairs = randomPairs();
    for (const NamedMaterial& entry : materials()) {
        BsdfCase test = entry.material;
        for (uint32_t lobe : entry.lobes) {
            test.lobe = lobe;
            for (const BsdfValues& value : evaluate(test, pairs)) {
                double sum = 0;
                for (const uint32_t present : entry.lobes)
                    sum += value.probabilities[present == LOBE_DIFFUSE ? 0 : present == LOBE_REFLECT ? 1 : 2];
                ASSERT_NEAR(sum, 1, 1e-5) << entry.name;
                ASSERT_TRUE(value.f == glm::vec3(0) || value.pdf > 0) << entry.name << ", lobe " << lobe;
            }
        }
    }
}

TEST(Bsdf, LabelsPartTheLobes)
{
    const auto pairs = randomPairs();
    for (const NamedMaterial& entry : materials()) {
        BsdfCase test = entry.material;
        test.lobe = LOBE_ALL;
        for (const BsdfValues& value : evaluate(test, pairs)) {
            const glm::vec3 labels = value.labelProbabilities;
            ASSERT_NEAR(labels.x + labels.y + labels.z, 1, 1e-5) << entry.name;
            ASSERT_NEAR(value.labelPdfSum, value.pdf, 1e-4 * (1 + value.pdf)) << entry.name;
            const bool sharp = test.roughness <= 0.2f;
            ASSERT_NEAR(labels.y, sharp ? value.probabilities.y : 0, 1e-6) << entry.name;
            ASSERT_NEAR(labels.z, sharp ? value.probabilities.z : 0, 1e-6) << entry.name;
        }
    }
}

TEST(Bsdf, SmoothGlassIsChosenByFresnelExactly)
{
    std::vector<DirectionPair> pairs = randomPairs();
    for (const char* name : {"smooth glass", "smooth glass from inside"}) {
        BsdfCase test = material(name);
        test.lobe = LOBE_ALL;
        const auto values = evaluate(test, pairs);
        for (size_t index = 0; index < pairs.size(); ++index) {
            const double f = dielectricFresnel(pairs[index].wo.z, test.entering ? 1.5 : 1 / 1.5);
            ASSERT_NEAR(values[index].probabilities.y, f, 2e-5) << name << ", cosine " << pairs[index].wo.z;
            ASSERT_NEAR(values[index].probabilities.z, 1 - f, 2e-5) << name << ", cosine " << pairs[index].wo.z;
        }
    }
}

TEST(Bsdf, WithoutSpecularItIsLambertsExactly)
{
    const auto pairs = randomPairs();
    BsdfCase test = material("lambert");
    test.lobe = LOBE_ALL;
    const auto values = evaluate(test, pairs);
    for (size_t index = 0; index < pairs.size(); ++index)
        for (int channel = 0; channel < 3; ++channel)
            ASSERT_NEAR(values[index].f[channel], pairs[index].wi.z > 0 ? test.baseColor[channel] / PI : 0, 1e-7);
}

TEST(Bsdf, NoMaterialOrDirectionBreaksIt)
{
    const Buffer results = device().createBuffer(sizeof(ExtremesFound), "extremes");
    run("bsdf_extremes", ExtremesCase{results.address()}, 1u << 21);
    ExtremesFound found;
    device().download(results, &found, sizeof(found));
    EXPECT_EQ(found.brokenValues, 0u);
    EXPECT_EQ(found.brokenPdfs, 0u);
    EXPECT_EQ(found.brokenSamples, 0u);
    // Lobes are chosen at least with MIN_LOBE_PROBABILITY, so weights stay near its inverse.
    EXPECT_LT(std::bit_cast<float>(found.largestWeight), 30.0f);
}

// ---- Reciprocity ----

TEST(Bsdf, ExchangingTheDirectionsChangesNothing)
{
    for (const NamedMaterial& entry : materials()) {
        if (entry.material.roughness < DELTA_ROUGHNESS && entry.lobes.front() != LOBE_DIFFUSE)
            continue;
        // The half vector's rounding, 1e-7, is felt relative to the lobe's width.
        const double alpha = std::max(double(entry.material.roughness) * entry.material.roughness, 1e-3);
        EXPECT_LT(reciprocityError(entry.material, ERROR_NONE), 2e-3 + 1e-5 / alpha) << entry.name;
    }
}

TEST(Bsdf, ARoughnessThatDiffersByOnePercentBreaksReciprocity)
{
    for (const char* name : {"rough plastic", "gold", "frosted glass", "tinted thin sheet"})
        EXPECT_GT(reciprocityError(material(name), ERROR_SWAP), 1e-2) << name;
}

}  // namespace
}  // namespace restirpg::test
