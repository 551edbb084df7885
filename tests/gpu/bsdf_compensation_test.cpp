// The BSDF with energy compensation: furnaces, chi-square and reciprocity as without it.
//
// Null hypotheses: a white material returns exactly 1 from every direction (2^18 draws, 4 standard errors and
// INTERPOLATION); counts of draws are multinomial with the pdf's integrals (1% over the test, Bonferroni); exchanging
// the directions changes nothing.
#include "../support/statistics.h"
#include "bsdf_measure.h"
#include "scene/energy_table.h"

#include <cmath>

namespace restirpg::test {
namespace {

/// What linear interpolation in the tables may be off.
constexpr double INTERPOLATION = 3e-3;
/// The same where roughness is below 0.2 and the cosine below 0.1: losses there are narrower than the table's columns.
constexpr double INTERPOLATION_AT_GRAZING = 2e-2;

const std::vector<float> ROUGHNESSES{0.1f, 0.35f, 0.6f, 1.0f};

/// Kernels of this program are all compiled with the compensation.
class Compensated : public ::testing::Test {
protected:
    static void SetUpTestSuite() { device().setKernelDefine("RESTIRPG_ENERGY_COMPENSATION", "1"); }
};

/// The address of an index's table, which lives as long as the process.
Address tableOf(float ior)
{
    static std::map<float, Buffer> tables;
    auto found = tables.find(ior);
    if (found == tables.end())
        found = tables.emplace(ior, device().createBuffer(energyTable(ior), "energy table")).first;
    return found->second.address();
}

BsdfCase compensated(const std::string& name)
{
    BsdfCase test = material(name);
    test.energyTable = tableOf(test.ior);
    test.lobe = LOBE_ALL;
    return test;
}

/// Expect that a white version of the material, of this roughness and index, returns everything.
void expectFurnace(BsdfCase test, float roughness, float ior, const std::string& name)
{
    test.baseColor = glm::vec3(1);
    test.roughness = roughness;
    test.ior = ior;
    test.coatAverage = float(coatAverage(ior));
    test.energyTable = tableOf(ior);
    for (const glm::vec3& wo : directions()) {
        test.wo = wo;
        const Albedo result = albedo(test, 1u << 14);
        const double off = roughness < 0.2f && wo.z < 0.1f ? INTERPOLATION_AT_GRAZING : INTERPOLATION;
        EXPECT_NEAR(result.mean.x, 1, 4 * result.standardError.x + off)
            << name << ", roughness " << roughness << ", ior " << ior << ", cosine " << wo.z;
    }
}

TEST_F(Compensated, WhiteMetalReturnsEverything)
{
    for (const float roughness : ROUGHNESSES)
        expectFurnace(compensated("roughest metal"), roughness, 1.5f, "metal");
}

TEST_F(Compensated, WhitePaintUnderARoughCoatReturnsEverything)
{
    for (const float ior : {1.2f, 2.0f})
        for (const float roughness : ROUGHNESSES)
            expectFurnace(compensated("rough plastic"), roughness, ior, "plastic");
}

TEST_F(Compensated, GlassAndSheetsReturnEverything)
{
    for (const float ior : {1.33f, 2.0f})
        for (const float roughness : ROUGHNESSES) {
            expectFurnace(compensated("frosted glass"), roughness, ior, "glass");
            expectFurnace(compensated("frosted glass from inside"), roughness, ior, "glass from inside");
        }
    for (const float roughness : ROUGHNESSES)
        for (const float ior : {1.0f, 1.0005f, 1.5f})
            expectFurnace(compensated("tinted thin sheet"), roughness, ior, "sheet");
}

TEST_F(Compensated, TheTableOfAnotherIndexBreaksTheFurnace)
{
    BsdfCase test = compensated("frosted glass from inside");
    test.baseColor = glm::vec3(1);
    test.energyTable = tableOf(1.2f);
    test.wo = directions()[0];
    const Albedo result = albedo(test);
    EXPECT_GT(std::abs(result.mean.x - 1), 10 * INTERPOLATION + 4 * result.standardError.x);
}

TEST_F(Compensated, NothingReturnsMoreThanItReceives)
{
    for (const NamedMaterial& entry : materials()) {
        BsdfCase test = compensated(entry.name);
        for (const glm::vec3& wo : directions()) {
            test.wo = wo;
            const Albedo result = albedo(test, 1u << 13);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_LT(result.mean[channel], 1 + 3.5 * result.standardError[channel] + INTERPOLATION_AT_GRAZING)
                    << entry.name << ", cosine " << wo.z;
        }
    }
}

TEST_F(Compensated, ColouredMetalGivesBackItsColourAgainAndAgain)
{
    // Light that meets a facet n times has the colour to the n-th power: what comes back must be darker than the colour
    // itself, and lighter than what single scattering gives.
    BsdfCase test = compensated("roughest metal");
    test.baseColor = glm::vec3(0.9f, 0.5f, 0.2f);
    test.wo = directions()[0];
    const Albedo all = albedo(test);
    test.lobe = LOBE_REFLECT;
    const Albedo single = albedo(test);
    for (int channel = 0; channel < 3; ++channel) {
        EXPECT_GT(all.mean[channel], single.mean[channel] + 3.5 * all.standardError[channel]);
        EXPECT_LT(all.mean[channel], test.baseColor[channel]);
    }
    EXPECT_GT(all.mean[0] / 0.9, 1.1 * all.mean[2] / 0.2);
}

TEST_F(Compensated, DrawsFollowTheirPdf)
{
    std::vector<BsdfCase> cases;
    for (const NamedMaterial& entry : materials())
        if (entry.material.roughness >= 0.3f)
            for (const uint32_t lobe : {LOBE_DIFFUSE, LOBE_ALL})
                for (const size_t direction : {size_t(1), size_t(3)}) {
                    cases.push_back(compensated(entry.name));
                    cases.back().lobe = lobe;
                    cases.back().wo = directions()[direction];
                    cases.back().domain = DOMAIN_SPHERE;
                    cases.back().seed = 5000 + uint32_t(cases.size());
                }
    for (const BsdfCase& test : cases) {
        const Integrals integrals = integrate(test);
        const Histogram drawn = sample(test);
        EXPECT_NEAR(integrals.mass, 1 - drawn.lost, 2e-3 + 4.5 * std::sqrt(drawn.lost / DRAWS));
        const ChiSquare result = chiSquare(drawn.counts, integrals.expected);
        EXPECT_GT(result.p, bonferroni(cases.size()))
            << "metallic " << test.metallic << ", transmission " << test.transmission << ", solid " << test.solid
            << ", lobe " << test.lobe << ", cosine " << test.wo.z << ": chi-square " << result.statistic;
        BsdfCase wrong = test;
        wrong.error = ERROR_BEND;
        if (test.lobe == LOBE_DIFFUSE && test.metallic == 1) {
            EXPECT_LT(chiSquare(sample(wrong).counts, integrals.expected).p, bonferroni(cases.size()));
        }
    }
}

TEST_F(Compensated, ExchangingTheDirectionsChangesNothing)
{
    for (const NamedMaterial& entry : materials()) {
        if (entry.material.roughness < DELTA_ROUGHNESS && entry.lobes.front() != LOBE_DIFFUSE)
            continue;
        const double alpha = std::max(double(entry.material.roughness) * entry.material.roughness, 1e-3);
        EXPECT_LT(reciprocityError(compensated(entry.name), ERROR_NONE), 2e-3 + 1e-5 / alpha) << entry.name;
    }
    for (const char* name : {"gold", "frosted glass", "tinted thin sheet"})
        EXPECT_GT(reciprocityError(compensated(name), ERROR_SWAP), 1e-2) << name;
}

/// Prints the table of benchmarks/results/ggx_energy_loss; run it with --gtest_also_run_disabled_tests.
TEST_F(Compensated, DISABLED_Table)
{
    std::printf(
        "| white | roughness | cos 1 | 0.8 | 0.5 | 0.15 | 0.01 |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (const char* name :
         {"roughest metal", "rough plastic", "frosted glass", "frosted glass from inside", "tinted thin sheet"})
        for (float roughness : {0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
            BsdfCase test = compensated(name);
            test.baseColor = glm::vec3(1);
            test.roughness = roughness;
            std::printf("| %s | %.1f |", name, roughness);
            for (const glm::vec3& wo : directions()) {
                test.wo = wo;
                std::printf(" %.3f |", albedo(test).mean.x);
            }
            std::printf("\n");
        }
}

}  // namespace
}  // namespace restirpg::test
