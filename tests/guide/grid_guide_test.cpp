// The guiding grid's samplers on the GPU: one von Mises-Fisher lobe, a cell's mixture as GuidingFit's module looks it
// up (with lobes multiplied by the cosine, or aimed at what they saw), and one-sample MIS of a BSDF and the guide.
//
// Null hypothesis of each chi-square: the counts of 2^20 draws in 64 x 32 bins of equal solid angle are multinomial
// with the integrals of the textbook density in double precision (of the GPU's own density where a BSDF takes part).
// False-alarm rate: 1% over the comparisons of a test. Samplers that are wrong on purpose must be rejected.
#include "../gpu/gpu_test.h"
#include "../support/statistics.h"
#include "grid_guide_case.h"

#include <cmath>
#include <functional>

namespace restirpg::test {
namespace {

constexpr uint32_t THREADS = 1u << 16;
constexpr double DRAWS = double(THREADS) * DRAWS_A_THREAD;
/// What the midpoint rule, single precision and the packed directions may be off, of the whole mass.
constexpr double MASS_ERROR = 2e-3;
/// Where GuidingFit's module looks the cell up (grid_guide_case.glsl): next to its middle.
const glm::dvec3 OFFSET = {0.1, -0.08, 0.05};

using Lobes = std::vector<TestLobe>;
using Density = std::function<double(const glm::dvec3&)>;

/// A guide of one cell in a buffer.
Buffer makeGuide(const Lobes& lobes, uint32_t options = 0, const GuidingMemory& memory = {})
{
    const uint64_t slot = GUIDING_KEY_BYTES + GUIDING_CELL_BYTES + GUIDING_MEMORY_BYTES;
    Buffer guide = device().createBuffer(std::vector<uint8_t>(GUIDING_HEADER_BYTES + slot * TEST_CAPACITY), "guide");
    const Buffer from = device().createBuffer(lobes, "lobes");
    const Buffer sums = device().createBuffer(std::vector{memory}, "memory");
    const GridGuideBuild build{guide.address(), from.address(), sums.address(), options};
    static const Kernel kernel(device(), RESTIRPG_SOURCE "/tests/guide/grid_guide_build.comp");
    device().submit([&](VkCommandBuffer commands) { kernel.dispatch(commands, &build, sizeof(build), 1); });
    return guide;
}

template <typename Value>
std::vector<Value> measure(const std::string& name, uint32_t threads, uint32_t values, GridGuideCase test)
{
    Device& target = device();  // first: static objects are destroyed in the reverse order of their making
    static std::map<std::string, Kernel> kernels;
    const std::string source = RESTIRPG_SOURCE;
    if (!kernels.contains(name))
        kernels[name] = Kernel(target, source + "/tests/guide/" + name + ".comp", {{"GUIDED", "1"}},
                               {{"guide_module.glsl", source + "/passes/GuidingFit/guide.glsl"}});
    const Buffer results = target.createBuffer(std::vector<Value>(values), "results");
    test.results = results.address();
    const BindingSet noScene(target);
    target.submit([&](VkCommandBuffer commands) {
        noScene.bind(commands);
        kernels[name].dispatch(commands, &test, sizeof(test), threads);
    });
    return target.download<Value>(results, values);
}

/// Draws: a bin each, then those outside.
std::vector<uint32_t> sample(const GridGuideCase& test)
{
    return measure<uint32_t>("grid_guide_sample", THREADS, BINS + 1, test);
}

/// The GPU's density in each bin.
std::vector<double> integrate(const GridGuideCase& test)
{
    const auto masses = measure<float>("grid_guide_integrate", BINS, BINS, test);
    return {masses.begin(), masses.end()};
}

/// A density in each bin, in double precision.
std::vector<double> integrate(const GridGuideCase& test, const Density& density)
{
    constexpr uint32_t STEPS = 12;
    const glm::dvec3 z = glm::normalize(glm::dvec3(test.axis));
    const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0.47, -0.63, 0.618), z)), y = glm::cross(z, x);
    std::vector<double> masses(BINS);
    for (uint32_t row = 0; row < BIN_ROWS * STEPS; ++row) {
        const double t = test.height * (row + 0.5) / (BIN_ROWS * STEPS), r = std::sqrt(t * (2 - t));
        for (uint32_t column = 0; column < BIN_COLUMNS * STEPS; ++column) {
            const double phi = 2 * M_PI * ((column + 0.5) / (BIN_COLUMNS * STEPS) - 0.5);
            masses[row / STEPS * BIN_COLUMNS + column / STEPS] +=
                density(r * std::cos(phi) * x + r * std::sin(phi) * y + (1 - t) * z);
        }
    }
    for (double& mass : masses)
        mass *= 2 * M_PI * test.height / double(BINS * STEPS * STEPS);
    return masses;
}

double massOf(const std::vector<double>& masses)
{
    return std::accumulate(masses.begin(), masses.end(), 0.0);
}

ChiSquare compare(const std::vector<uint32_t>& counts, const std::vector<double>& masses)
{
    std::vector<double> expected;
    for (const double mass : masses)
        expected.push_back(mass * DRAWS);
    expected.push_back(std::max(1 - massOf(masses), 0.0) * DRAWS);
    return chiSquare(counts, expected);
}

/// The textbook's vMF density [shaders/README: The von Mises-Fisher distribution].
double vmf(const glm::dvec3& w, const glm::dvec3& mu, double kappa)
{
    if (kappa == 0)
        return 0.25 / M_PI;
    return kappa / (2 * M_PI * -std::expm1(-2 * kappa)) * std::exp(-0.5 * kappa * glm::dot(w - mu, w - mu));
}

double mixture(const Lobes& lobes, const glm::dvec3& w)
{
    double sum = 0;
    for (const TestLobe& lobe : lobes)
        sum += lobe.weight * vmf(w, glm::normalize(glm::dvec3(lobe.mu)), lobe.kappa);
    return sum;
}

// ---- One lobe ----

struct NamedLobe {
    float kappa;
    glm::vec3 mu;
};

/// From uniform to the most concentrated, about axes where frames are delicate, too.
const std::vector<NamedLobe> LOBES = {{0, {0, 0, 1}},
                                      {1e-3f, glm::normalize(glm::vec3(1, -2, 0.5f))},
                                      {0.05f, {0, 0, -1}},
                                      {1, glm::normalize(glm::vec3(0.3f, 0.2f, -1e-4f))},
                                      {10, {1, 0, 0}},
                                      {300, glm::normalize(glm::vec3(-1, 1e-3f, -5))},
                                      {32000, glm::normalize(glm::vec3(0.2f, 0.9f, 0.1f))}};

/// Bins about the lobe's axis as far as it reaches; about another axis where it is broad, for that shows its azimuth.
GridGuideCase caseOf(const NamedLobe& lobe, const Buffer& guide)
{
    GridGuideCase test{};
    test.guide = guide.address();
    test.technique = TECHNIQUE_VMF;
    test.mu = lobe.mu;
    test.kappa = lobe.kappa;
    test.height = std::min(2.0f, 12 / std::max(lobe.kappa, 1e-3f));
    test.axis = test.height < 2 ? lobe.mu : glm::normalize(glm::vec3(0.5f, 0.7f, -0.4f));
    test.wo = {0, 0, 1};
    test.roughness = 1;
    test.seed = 21;
    return test;
}

const Lobes ANY_LOBES(4, {{0, 0, 1}, 1, 0.25f});

TEST(GridGuide, AVmfLobeDrawsFromTheTextbooksDensityAndHasIt)
{
    const Buffer guide = makeGuide(ANY_LOBES);
    for (const NamedLobe& lobe : LOBES) {
        const GridGuideCase test = caseOf(lobe, guide);
        const auto expected = integrate(
            test, [&](const glm::dvec3& w) { return vmf(w, glm::normalize(glm::dvec3(lobe.mu)), lobe.kappa); });
        const ChiSquare result = compare(sample(test), expected);
        EXPECT_GT(result.p, bonferroni(LOBES.size())) << "kappa " << lobe.kappa << ": chi-square " << result.statistic
                                                      << " with " << result.degrees << " degrees of freedom";
        const auto masses = integrate(test);
        EXPECT_NEAR(massOf(masses), 1, MASS_ERROR) << "kappa " << lobe.kappa;
        for (uint32_t bin = 0; bin < BINS; ++bin)
            EXPECT_NEAR(masses[bin], expected[bin], 1e-2 * expected[bin] + 1e-9)
                << "kappa " << lobe.kappa << ", bin " << bin;
    }
}

TEST(GridGuide, AKappaThatIsFivePercentTooLargeIsRejected)
{
    const Buffer guide = makeGuide(ANY_LOBES);
    for (NamedLobe lobe : LOBES) {
        if (lobe.kappa < 1)
            continue;  // 5% of hardly any concentration do not show in 2^20 draws
        const GridGuideCase right = caseOf(lobe, guide);
        GridGuideCase wrong = right;
        wrong.kappa *= 1.05f;
        EXPECT_LT(compare(sample(wrong), integrate(right)).p, bonferroni(LOBES.size())) << "kappa " << lobe.kappa;
    }
}

// ---- A cell's mixture ----

const Lobes MIXTURE = {{{0.6f, 0.0f, 0.8f}, 6, 0.4f},
                       {glm::normalize(glm::vec3(-0.5f, 0.6f, 0.4f)), 25, 0.3f},
                       {{0, 0.8f, 0.6f}, 90, 0.2f},
                       {glm::normalize(glm::vec3(0.1f, -1, 0.05f)), 2, 0.1f}};

GridGuideCase caseOfGuide(const Buffer& guide)
{
    GridGuideCase test = caseOf({0, {0, 0, 1}}, guide);
    test.technique = TECHNIQUE_GUIDE;
    return test;
}

void expectDensity(const GridGuideCase& test, const std::string& what, const Density& density, uint32_t comparisons)
{
    const auto expected = integrate(test, density);
    const ChiSquare result = compare(sample(test), expected);
    EXPECT_GT(result.p, bonferroni(comparisons))
        << what << ": chi-square " << result.statistic << " with " << result.degrees << " degrees of freedom";
    const auto masses = integrate(test);
    EXPECT_NEAR(massOf(masses), 1, MASS_ERROR) << what;
    for (uint32_t bin = 0; bin < BINS; ++bin)
        EXPECT_NEAR(masses[bin], expected[bin], 1e-2 * expected[bin] + 1e-7) << what << ", bin " << bin;
}

TEST(GridGuide, ACellsMixtureIsWhatItsLobesSay)
{
    const Buffer guide = makeGuide(MIXTURE);
    expectDensity(
        caseOfGuide(guide), "mixture", [](const glm::dvec3& w) { return mixture(MIXTURE, w); }, 1);
}

TEST(GridGuide, LobesTimesTheCosineAreTheProductNormalised)
{
    constexpr double COSINE_KAPPA = 2.18853;  // guide.glsl
    const Density product = [](const glm::dvec3& w) {
        return mixture(MIXTURE, w) * std::exp(COSINE_KAPPA * (w.z - 1));
    };
    const Buffer guide = makeGuide(MIXTURE, GUIDING_COSINE);
    const GridGuideCase test = caseOfGuide(guide);
    const double mass = massOf(integrate(test, product));
    expectDensity(
        test, "times the cosine", [&](const glm::dvec3& w) { return product(w) / mass; }, 1);
}

TEST(GridGuide, LobesAreAimedAtWhatTheirSamplesSaw)
{
    GuidingMemory memory{};
    memory.count = 10;
    const std::vector<double> distances = {0.5, 2, 1e4, 0.8};
    for (uint32_t k = 0; k < GUIDING_LOBES; ++k) {
        memory.sums[4 * k + 3] = 2.5f;
        memory.inverseDistances[k] = float(2.5 / distances[k]);
    }
    Lobes aimed = MIXTURE;
    for (uint32_t k = 0; k < GUIDING_LOBES; ++k) {
        const glm::dvec3 target = distances[k] * glm::normalize(glm::dvec3(MIXTURE[k].mu));
        aimed[k].mu = glm::vec3(glm::normalize(target - OFFSET));
    }
    const Buffer guide = makeGuide(MIXTURE, GUIDING_PARALLAX, memory);
    expectDensity(
        caseOfGuide(guide), "aimed", [&](const glm::dvec3& w) { return mixture(aimed, w); }, 1);
    EXPECT_LT(compare(sample(caseOfGuide(makeGuide(MIXTURE))), integrate(caseOfGuide(guide))).p, 1e-6)
        << "unaimed lobes must be rejected";
}

TEST(GridGuide, ALobeWhoseWeightIsFivePercentOffIsRejected)
{
    Lobes wrong = MIXTURE;
    wrong[0].weight *= 0.95f;
    wrong[1].weight += 0.05f * MIXTURE[0].weight;
    const Buffer right = makeGuide(MIXTURE), off = makeGuide(wrong);
    EXPECT_LT(compare(sample(caseOfGuide(off)), integrate(caseOfGuide(right))).p, bonferroni(1));
}

TEST(GridGuide, WeightsThatSumToMoreThanOneFailTheIntegral)
{
    Lobes wrong = MIXTURE;
    for (TestLobe& lobe : wrong)
        lobe.weight *= 1.005f;
    const Buffer guide = makeGuide(wrong);
    EXPECT_GT(massOf(integrate(caseOfGuide(guide))), 1 + MASS_ERROR);
}

// ---- One-sample MIS with a BSDF ----

struct NamedSurface {
    std::string name;
    float roughness, metallic;
    glm::vec3 wo;
};

const std::vector<NamedSurface> SURFACES = {{"plastic, head-on", 0.9f, 0, {0, 0, 1}},
                                            {"plastic, grazing", 0.6f, 0, glm::normalize(glm::vec3(0.9f, 0.1f, 0.25f))},
                                            {"metal", 0.5f, 1, glm::normalize(glm::vec3(-0.4f, 0.5f, 0.8f))}};

GridGuideCase caseOfSurface(const NamedSurface& surface, const Buffer& guide, float alpha)
{
    GridGuideCase test = caseOfGuide(guide);
    test.technique = TECHNIQUE_SCATTER;
    test.roughness = surface.roughness;
    test.metallic = surface.metallic;
    test.wo = surface.wo;
    test.alpha = alpha;
    return test;
}

TEST(GridGuide, OneSampleOfBsdfAndGuideHasTheMixturesDensity)
{
    const Buffer guide = makeGuide(MIXTURE);
    for (const NamedSurface& surface : SURFACES)
        for (const float alpha : {0.0f, 0.5f, 0.9f}) {
            const GridGuideCase test = caseOfSurface(surface, guide, alpha);
            const auto masses = integrate(test);
            const auto counts = sample(test);
            const ChiSquare result = compare(counts, masses);
            EXPECT_GT(result.p, bonferroni(3 * SURFACES.size()))
                << surface.name << ", alpha " << alpha << ": chi-square " << result.statistic << " with "
                << result.degrees << " degrees of freedom";
            EXPECT_NEAR(massOf(masses), 1 - counts.back() / DRAWS, MASS_ERROR) << surface.name << ", alpha " << alpha;
        }
}

TEST(GridGuide, AnAlphaThatIsFivePercentOffIsRejected)
{
    const Buffer guide = makeGuide(MIXTURE);
    for (const NamedSurface& surface : SURFACES)
        EXPECT_LT(
            compare(sample(caseOfSurface(surface, guide, 0.525f)), integrate(caseOfSurface(surface, guide, 0.5f))).p,
            bonferroni(SURFACES.size()))
            << surface.name;
}

}  // namespace
}  // namespace restirpg::test
