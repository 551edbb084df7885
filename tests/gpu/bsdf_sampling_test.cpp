// Do the samplers of the BSDF draw what their pdfs say?
//
// Null hypothesis of each comparison: the counts of 2^20 draws in 64 x 32 bins are multinomial with the pdf's integral
// over each bin. False-alarm rate: 1% over all comparisons of a test (Bonferroni). The same comparison must reject
// samplers and pdfs that are wrong on purpose.
#include "../support/statistics.h"
#include "bsdf_measure.h"

#include <fmt/format.h>

#include <cmath>

namespace restirpg::test {
namespace {

/// What the midpoint rule over 1024 points a bin may be off, of the whole mass.
constexpr double QUADRATURE_ERROR = 2e-3;

/// Below this mass (next to total internal reflection) a lobe lives where the quadrature has no points, and has no
/// draws to speak of.
constexpr double MASS_TO_TEST = 1e-3;

struct Case {
    std::string name;
    BsdfCase test;
};

/// Every rough lobe alone, and the whole BSDF where it is broad enough for bins on the sphere, seen from every
/// direction.
std::vector<Case> allCases()
{
    std::vector<Case> cases;
    for (const NamedMaterial& entry : materials()) {
        std::vector<uint32_t> lobes;
        for (uint32_t lobe : entry.lobes)
            if (lobe == LOBE_DIFFUSE || entry.material.roughness >= DELTA_ROUGHNESS)
                lobes.push_back(lobe);
        if (entry.material.roughness >= 0.3f && lobes.size() > 1)
            lobes.push_back(LOBE_ALL);
        for (uint32_t lobe : lobes)
            for (size_t direction = 0; direction < directions().size(); ++direction) {
                Case made{fmt::format("{}, lobe {}, direction {}", entry.name, lobe, direction), entry.material};
                made.test.lobe = lobe;
                made.test.wo = directions()[direction];
                made.test.domain = domainOf(made.test);
                made.test.seed = 1000 + uint32_t(cases.size());
                cases.push_back(made);
            }
    }
    return cases;
}

/// A case with its draws and the integrals of its pdf, which several tests need.
struct Measured {
    std::string name;
    BsdfCase test;
    Histogram drawn;
    Integrals integrals;
};

const std::vector<Measured>& measuredCases()
{
    static const auto all = [] {
        std::vector<Measured> made;
        for (const Case& entry : allCases())
            made.push_back({entry.name, entry.test, sample(entry.test), integrate(entry.test)});
        return made;
    }();
    return all;
}

double falseAlarmRate()
{
    return bonferroni(measuredCases().size());
}

TEST(BsdfSampling, EveryLobeDrawsFromItsPdf)
{
    for (const Measured& entry : measuredCases()) {
        if (entry.integrals.mass < MASS_TO_TEST)
            continue;
        const ChiSquare result = chiSquare(entry.drawn.counts, entry.integrals.expected);
        EXPECT_GT(result.p, falseAlarmRate())
            << entry.name << ": chi-square " << result.statistic << " with " << result.degrees << " degrees of freedom";
    }
}

/// How far the integral of the pdf may be from the share of draws that were not lost: 4.5 standard errors of that
/// share, and the quadrature's own error.
double massTolerance(const Measured& entry)
{
    const double lost = entry.drawn.lost;
    return QUADRATURE_ERROR + 4.5 * std::sqrt(std::max(lost * (1 - lost), 1 / DRAWS) / DRAWS);
}

TEST(BsdfSampling, EveryPdfIntegratesToOneLessTheLostDraws)
{
    for (const Measured& entry : measuredCases())
        EXPECT_NEAR(entry.integrals.mass, 1 - entry.drawn.lost, massTolerance(entry)) << entry.name;
}

/// A lobe whose draws are mostly lost (behind the horizon, or under total internal reflection) has few left to test
/// with.
constexpr double MASS_THAT_SHOWS = 0.5;

/// Expect that the chi-square test rejects every case of a lobe whose sampler is wrong in a given way.
void expectRejection(uint32_t error, uint32_t lobe)
{
    for (const Measured& entry : measuredCases()) {
        if (entry.test.lobe != lobe || entry.integrals.mass < MASS_THAT_SHOWS)
            continue;
        BsdfCase wrong = entry.test;
        wrong.error = error;
        EXPECT_LT(chiSquare(sample(wrong).counts, entry.integrals.expected).p, falseAlarmRate()) << entry.name;
    }
}

TEST(BsdfSampling, ADiffuseSamplerThatIsFivePercentUnevenIsRejected)
{
    expectRejection(ERROR_BEND, LOBE_DIFFUSE);
}

TEST(BsdfSampling, AnAlphaThatIsFivePercentTooLargeIsRejected)
{
    expectRejection(ERROR_ALPHA, LOBE_REFLECT);
    expectRejection(ERROR_ALPHA, LOBE_TRANSMIT);
}

TEST(BsdfSampling, ALobeSelectionThatIsTenPercentOffIsRejected)
{
    expectRejection(ERROR_LOBE, LOBE_ALL);
}

TEST(BsdfSampling, APdfThatIsTwoPercentTooLargeFailsTheIntegral)
{
    for (const Measured& entry : measuredCases()) {
        if (entry.integrals.mass < MASS_THAT_SHOWS)
            continue;
        BsdfCase wrong = entry.test;
        wrong.error = ERROR_PDF;
        EXPECT_GT(std::abs(integrate(wrong).mass - (1 - entry.drawn.lost)), massTolerance(entry)) << entry.name;
    }
}

}  // namespace
}  // namespace restirpg::test
