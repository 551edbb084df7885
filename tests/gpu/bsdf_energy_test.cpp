// How much light the BSDF returns: the white furnace of each material, one direction at a time.
//
// Null hypothesis of the upper bounds: the mean weight of 2^20 draws is at most 1. False-alarm rate: 3 to 3.5 standard
// errors a comparison.
#include "bsdf_measure.h"

#include <cmath>
#include <cstdio>

namespace restirpg::test {
namespace {

TEST(BsdfEnergy, ReflectsNoMoreThanItReceives)
{
    for (const NamedMaterial& entry : materials())
        for (const glm::vec3& wo : directions()) {
            BsdfCase test = entry.material;
            test.wo = wo;
            test.lobe = LOBE_ALL;
            const Albedo result = albedo(test);
            for (int channel = 0; channel < 3; ++channel)
                EXPECT_LT(result.mean[channel], 1 + 3 * result.standardError[channel] + 1e-5)
                    << entry.name << ", cosine " << wo.z;
        }
}

TEST(BsdfEnergy, WhiteSurfacesWithoutRoughnessReflectEverything)
{
    BsdfCase lambert = material("lambert");
    lambert.baseColor = glm::vec3(1);
    BsdfCase dull = material("smooth glass from inside"), duller = dull;  // where it reflects totally, it still does
    dull.specular = 0.5f;
    duller.specular = 0;
    for (BsdfCase test : {lambert, material("smooth plastic"), material("smooth glass"),
                          material("smooth glass from inside"), material("smooth thin sheet"), dull, duller})
        for (const glm::vec3& wo : directions()) {
            test.wo = wo;
            test.lobe = LOBE_ALL;
            const Albedo result = albedo(test);
            EXPECT_NEAR(result.mean.x, 1, 3.5 * result.standardError.x + 2e-5) << "cosine " << wo.z;
        }
}

TEST(BsdfEnergy, ACoatAverageThatIsThreeHundredthsTooLargeBreaksTheFurnace)
{
    BsdfCase test = material("smooth plastic");
    test.coatAverage += 0.03f;
    test.wo = glm::vec3(0, 0, 1);
    test.lobe = LOBE_ALL;
    const Albedo result = albedo(test);
    EXPECT_GT(result.mean.x, 1.02 + 3.5 * result.standardError.x);
}

TEST(BsdfEnergy, EnergyOfWhitePaintUnderARoughCoatIsKept)
{
    // What may go: the coat's own single-scattering loss and the fit of coat_cosine, at most 12% (at grazing, or at ior
    // 2). What may come: 0.005, the fit's other side.
    for (float roughness : {0.05f, 0.1f, 0.2f, 0.3f, 0.4f, 0.5f, 0.6f, 0.7f, 0.8f, 0.9f, 1.0f})
        for (float ior : {0.0f, 1.2f, 1.5f, 2.0f})  // 0: a coat that converted specular-glossiness has
            for (const glm::vec3& wo : directions()) {
                BsdfCase test = material("rough plastic");
                test.baseColor = glm::vec3(1);
                test.roughness = roughness;
                test.ior = ior;
                test.specularColor = glm::vec3(ior == 0 ? 0.1f : 1);  // of ior 0, F0 itself
                test.coatAverage = float(coatAverage(ior));
                test.wo = wo;
                test.lobe = LOBE_ALL;
                const Albedo result = albedo(test, 1u << 14);
                const double noise = 3.5 * result.standardError.x;
                EXPECT_LT(result.mean.x, 1.005 + noise)
                    << "roughness " << roughness << ", ior " << ior << ", cosine " << wo.z;
                EXPECT_GT(result.mean.x, 0.88 - noise)
                    << "roughness " << roughness << ", ior " << ior << ", cosine " << wo.z;
            }
}

TEST(BsdfEnergy, AnInfiniteIorReflectsEverythingWhateverIsBelow)
{
    for (const glm::vec3& color : {glm::vec3(0), glm::vec3(1)})
        for (const glm::vec3& wo : directions()) {
            BsdfCase test = material("smooth plastic");
            test.baseColor = color;
            test.ior = 0;
            test.coatAverage = float(coatAverage(0));
            test.wo = wo;
            test.lobe = LOBE_ALL;
            const Albedo result = albedo(test, 1u << 14);
            EXPECT_NEAR(result.mean.x, 1, 3.5 * result.standardError.x + 2e-5) << "cosine " << wo.z;
        }
}

TEST(BsdfEnergy, TheRoughestWhiteMetalReflectsItsClosedForm)
{
    // GGX with alpha = 1 has the single-scattering albedo 1 - ln 2 at normal incidence.
    BsdfCase test = material("roughest metal");
    test.wo = glm::vec3(0, 0, 1);
    test.lobe = LOBE_ALL;
    const Albedo result = albedo(test);
    EXPECT_NEAR(result.mean.x, 1 - std::log(2.0), 4 * result.standardError.x);
}

/// Prints the table of benchmarks/results/ggx_energy_loss; run it with --gtest_also_run_disabled_tests.
TEST(BsdfEnergy, DISABLED_LossTable)
{
    std::printf(
        "| white | roughness | cos 1 | 0.8 | 0.5 | 0.15 | 0.01 |\n| --- | --- | --- | --- | --- | --- | --- |\n");
    for (const char* name :
         {"roughest metal", "rough plastic", "frosted glass", "frosted glass from inside", "tinted thin sheet"})
        for (float roughness : {0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f}) {
            BsdfCase test = material(name);
            test.baseColor = glm::vec3(1);
            test.roughness = roughness;
            test.lobe = LOBE_ALL;
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
