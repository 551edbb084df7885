// GuidingScreen's lobes on the GPU: is the sampler's density the one it claims, how much of it is lost, and does a fit
// give the moments of its samples?
//
// Null hypothesis of each chi-square: the counts of 2^20 draws are multinomial with the integrals of the pdf, those
// without a direction with the mass that it lacks. False-alarm rate: 1% over the comparisons of a test. Errors made on
// purpose must be rejected.
#include "../gpu/gpu_test.h"
#include "../support/statistics.h"
#include "screen_lobe_case.h"

#include <cmath>
#include <random>

namespace restirpg::test {
namespace {

constexpr uint32_t THREADS = 1u << 16;
constexpr double DRAWS = double(THREADS) * DRAWS_A_THREAD;
/// What the midpoint rule may be off where the horizon cuts bins, of the whole.
constexpr double QUADRATURE_ERROR = 2e-3;

struct NamedLobe {
    std::string name;
    glm::vec3 normal;
    float zoom;
    ScreenLobe lobe;
};

ScreenLobe gaussian(glm::vec2 mean, glm::vec3 factor)
{
    return {SCREEN_LOBE_GAUSSIAN, mean, factor};
}

ScreenLobe vmf(glm::vec2 mean, float kappa)
{
    return {SCREEN_LOBE_VMF, mean, {kappa, 0, 0}};
}

const glm::vec3 UP = {0, 0, 1}, WALL = {1, 0, 0}, TILTED = glm::normalize(glm::vec3(-0.3f, 0.8f, -0.5f)),
                FRAMES_SINGULARITY = glm::normalize(glm::vec3(0.47f, -0.63f, 0.618f));

const std::vector<NamedLobe> LOBES = {
    {"broad Gaussian", UP, 0, gaussian({0.5f, 0.5f}, {0.3f, 0, 0.3f})},
    {"broad Gaussian at a corner", TILTED, 0, gaussian({0.02f, 0.95f}, {0.3f, -0.1f, 0.25f})},
    {"oblong Gaussian", WALL, 0, gaussian({0.6f, 0.3f}, {0.2f, 0.15f, 0.03f})},
    {"oblong Gaussian along an edge", FRAMES_SINGULARITY, 0, gaussian({0.99f, 0.5f}, {0.02f, 0, 0.2f})},
    {"narrow Gaussian", UP, 0.2f, gaussian({0.45f, 0.52f}, {0.01f, 0.004f, 0.01f})},
    {"narrow Gaussian at an edge", TILTED, 0.2f, gaussian({0.3f, 0.995f}, {0.01f, 0, 0.012f})},
    {"uniform vMF", UP, 0, vmf({0.5f, 0.5f}, 0)},
    {"broad vMF", TILTED, 0, vmf({0.3f, 0.4f}, 2)},
    {"vMF at the horizon", WALL, 0, vmf({0.99f, 0.3f}, 30)},
    {"narrow vMF", FRAMES_SINGULARITY, 0.15f, vmf({0.2f, 0.6f}, 1500)},
    {"narrowest vMF", UP, 0.05f, vmf({0.5f, 0.999f}, 10000)},
};

/// What `kernel` counts or integrates of a lobe.
template <typename Value>
std::vector<Value> measure(const std::string& kernel, uint32_t threads, uint32_t values, const NamedLobe& lobe,
                           uint32_t error)
{
    const std::string source = RESTIRPG_SOURCE;
    Device& target = device();  // first: static objects are destroyed in the reverse order of their making
    static std::map<std::string, Kernel> kernels;
    if (!kernels.contains(kernel))
        kernels[kernel] = Kernel(target, source + "/tests/guide/" + kernel + ".comp", {{"GUIDED", "1"}},
                                 {{"guide_module.glsl", source + "/passes/GuidingScreen/guide.glsl"}});
    FrameConstants constants{};
    constants.size = {1, 1};
    const Buffer frame = target.createBuffer(std::vector{constants}, "frame");
    const Buffer guide = target.createBuffer(std::vector{lobe.lobe}, "lobe");
    const Buffer results = target.createBuffer(values * sizeof(Value), "results");
    const LobeCase test{frame.address(), guide.address(), results.address(), lobe.normal, lobe.zoom, 7, error};
    const BindingSet noScene(target);
    target.submit([&](VkCommandBuffer commands) {
        noScene.bind(commands);
        kernels[kernel].dispatch(commands, &test, sizeof(test), threads);
    });
    return target.download<Value>(results, values);
}

/// Draws: a bin each, then those without a bin.
std::vector<uint32_t> sample(const NamedLobe& lobe, uint32_t error = ERROR_NONE)
{
    return measure<uint32_t>("screen_lobe_sample", THREADS, BINS + 1, lobe, error);
}

/// The pdf's mass in each bin.
std::vector<float> integrate(const NamedLobe& lobe, uint32_t error = ERROR_NONE)
{
    return measure<float>("screen_lobe_integrate", BINS, BINS, lobe, error);
}

double massOf(const std::vector<float>& bins)
{
    return std::accumulate(bins.begin(), bins.end(), 0.0);
}

/// Integral of the standard normal density from a to b.
double normalMass(double a, double b)
{
    return 0.5 * (std::erfc(a / std::sqrt(2.0)) - std::erfc(b / std::sqrt(2.0)));
}

/// The mass of a lobe's density over all directions, by integrals of its textbook form; all of it for a vMF.
double expectedMass(const ScreenLobe& lobe)
{
    if (lobe.kind == SCREEN_LOBE_VMF)
        return 1;
    constexpr int STEPS = 20000;
    const double l11 = lobe.spread.x, l21 = lobe.spread.y, l22 = lobe.spread.z;
    double mass = 0;
    for (int i = 0; i < STEPS; ++i) {
        const double x = (i + 0.5) / STEPS;
        const double n = (x - lobe.mean.x) / l11;
        const double centre = lobe.mean.y + l21 * n;
        mass +=
            std::exp(-0.5 * n * n) / std::sqrt(2 * M_PI) / l11 / STEPS * normalMass(-centre / l22, (1 - centre) / l22);
    }
    return mass;
}

ChiSquare compare(const std::vector<uint32_t>& counts, const std::vector<float>& masses)
{
    std::vector<double> expected;
    for (const float mass : masses)
        expected.push_back(mass * DRAWS);
    expected.push_back(std::max(1 - massOf(masses), 0.0) * DRAWS);
    return chiSquare(counts, expected);
}

TEST(ScreenLobe, DrawsFollowThePdfAndAreLostByItsMissingMass)
{
    for (const NamedLobe& lobe : LOBES) {
        const ChiSquare result = compare(sample(lobe), integrate(lobe));
        EXPECT_GT(result.p, bonferroni(LOBES.size()))
            << lobe.name << ": chi-square " << result.statistic << " with " << result.degrees << " degrees of freedom";
    }
}

TEST(ScreenLobe, ASamplerThatIsFivePercentUnevenIsRejected)
{
    for (const NamedLobe& lobe : LOBES)
        EXPECT_LT(compare(sample(lobe, ERROR_BEND), integrate(lobe)).p, bonferroni(LOBES.size())) << lobe.name;
}

TEST(ScreenLobe, ThePdfIntegratesToWhatLiesInTheSquare)
{
    for (const NamedLobe& lobe : LOBES) {
        const double expected = expectedMass(lobe.lobe);
        EXPECT_NEAR(massOf(integrate(lobe)), expected, QUADRATURE_ERROR) << lobe.name;
        EXPECT_GT(std::abs(massOf(integrate(lobe, ERROR_PDF)) - expected), QUADRATURE_ERROR)
            << lobe.name << ": a pdf that is 2% too large must fail";
    }
}

TEST(ScreenLobe, APixelWithoutLightDoesNotGuide)
{
    const NamedLobe none = {"none", UP, 0, {SCREEN_LOBE_NONE, {0.5f, 0.5f}, {0.3f, 0, 0.3f}}};
    EXPECT_EQ(massOf(integrate(none)), 0);
    const auto counts = sample(none);
    EXPECT_EQ(std::accumulate(counts.begin(), counts.end(), 0u), 0u);
}

// ---- Fits ----

/// sampling.glsl's concentric map, then Lambert's projection, in double precision.
glm::dvec3 hemisphereOfSquare(glm::dvec2 place)
{
    const glm::dvec2 p = 2.0 * place - 1.0;
    if (p == glm::dvec2(0))
        return {0, 0, 1};
    const bool wide = std::abs(p.x) > std::abs(p.y);
    const double radius = wide ? p.x : p.y;
    const double phi = wide ? M_PI / 4 * p.y / p.x : M_PI / 2 - M_PI / 4 * p.x / p.y;
    const double scale = radius * std::sqrt(2 - radius * radius);
    return {scale * std::cos(phi), scale * std::sin(phi), 1 - radius * radius};
}

struct PlacedSample {
    glm::dvec2 place;
    double weight;
};

/// The lobe that the kernel fits to samples on a surface of normal TILTED.
ScreenLobe fit(uint32_t kind, const std::vector<PlacedSample>& placed, float prior, float regularisation,
               float floor = 1e-6f)
{
    const glm::dvec3 n = TILTED;
    const glm::dvec3 x = glm::normalize(glm::cross(glm::dvec3(0.47, -0.63, 0.618), n));
    const glm::dmat3 frame(x, glm::cross(n, x), n);
    std::vector<FitSample> samples;
    for (const PlacedSample& s : placed)
        samples.push_back({glm::vec3(frame * hemisphereOfSquare(s.place)), float(s.weight)});
    const Buffer input = device().createBuffer(samples, "samples");
    const Buffer result = device().createBuffer(sizeof(ScreenLobe), "lobe");
    static const Kernel kernel(device(), RESTIRPG_SOURCE "/tests/guide/screen_lobe_fit.comp");
    const FitCase test{input.address(), result.address(), TILTED, uint32_t(samples.size()), kind, floor,
                       prior,           regularisation};
    device().submit([&](VkCommandBuffer commands) { kernel.dispatch(commands, &test, sizeof(test), 1); });
    return device().download<ScreenLobe>(result, 1)[0];
}

/// Draws of a correlated distribution with weights of many sizes.
std::vector<PlacedSample> manySamples()
{
    std::mt19937 numbers(5);
    std::normal_distribution<double> normal;
    std::vector<PlacedSample> samples;
    for (int i = 0; i < 4000; ++i) {
        const double a = normal(numbers), b = normal(numbers);
        samples.push_back(
            {glm::clamp(glm::dvec2(0.4 + 0.1 * a, 0.6 + 0.05 * a + 0.04 * b), 0.01, 0.99), std::exp(normal(numbers))});
    }
    return samples;
}

TEST(ScreenLobeFit, AGaussianHasTheMomentsOfItsWeightedSamples)
{
    const auto samples = manySamples();
    double weight = 0;
    glm::dvec2 mean(0);
    glm::dvec3 moment(0);
    for (const auto& [z, w] : samples) {
        weight += w;
        mean += w * z;
        moment += w * glm::dvec3(z * z, z.x * z.y);
    }
    mean /= weight;
    moment = moment / weight - glm::dvec3(mean * mean, mean.x * mean.y);
    const ScreenLobe lobe = fit(SCREEN_LOBE_GAUSSIAN, samples, 0, 0);
    const auto& l = lobe.spread;
    EXPECT_NEAR(lobe.mean.x, mean.x, 1e-4);
    EXPECT_NEAR(lobe.mean.y, mean.y, 1e-4);
    EXPECT_NEAR(l.x * l.x, moment.x, 1e-4 * 0.1);
    EXPECT_NEAR(l.x * l.y, moment.z, 1e-4 * 0.1);
    EXPECT_NEAR(l.y * l.y + l.z * l.z, moment.y, 1e-4 * 0.1);
}

TEST(ScreenLobeFit, AVmfHasTheResultantOfItsWeightedSamples)
{
    const auto samples = manySamples();
    double weight = 0;
    glm::dvec3 sum(0);
    for (const auto& [z, w] : samples) {
        weight += w;
        sum += w * hemisphereOfSquare(z);
    }
    const double r = glm::length(sum) / weight;
    const ScreenLobe lobe = fit(SCREEN_LOBE_VMF, samples, 0, 0);
    EXPECT_NEAR(lobe.spread.x / (r * (3 - r * r) / (1 - r * r)), 1, 1e-3);
    EXPECT_LT(glm::distance(hemisphereOfSquare(lobe.mean), sum / glm::length(sum)), 1e-4);
}

TEST(ScreenLobeFit, OneSampleAndAPriorOfOneMeetHalfWay)
{
    const ScreenLobe lobe = fit(SCREEN_LOBE_GAUSSIAN, {{{0.3, 0.9}, 5.0}}, 1, 0);
    EXPECT_NEAR(lobe.mean.x, 0.4, 1e-5);
    EXPECT_NEAR(lobe.mean.y, 0.7, 1e-5);
    EXPECT_NEAR(lobe.spread.x * lobe.spread.x, (0.09 + 1.0 / 3) / 2 - 0.16, 1e-5);
}

TEST(ScreenLobeFit, AFireflyCountsAsOneSample)
{
    std::vector<PlacedSample> samples(500, {{0.2, 0.2}, 1e-3});
    samples.push_back({{0.8, 0.8}, 1e3});
    const ScreenLobe lobe = fit(SCREEN_LOBE_GAUSSIAN, samples, 1, 0);
    EXPECT_NEAR(lobe.mean.x, 0.65, 1e-3);
    EXPECT_GT(lobe.spread.z, 0.1);
}

TEST(ScreenLobeFit, ADecayingMeanForgets)
{
    std::vector<PlacedSample> samples(200, {{0.2, 0.2}, 1.0});
    samples.insert(samples.end(), 100, {{0.8, 0.8}, 1.0});
    EXPECT_NEAR(fit(SCREEN_LOBE_GAUSSIAN, samples, 0, 0).mean.x, 0.4, 1e-4);
    EXPECT_NEAR(fit(SCREEN_LOBE_GAUSSIAN, samples, 0, 0, 0.05f).mean.x, 0.8 - 0.6 * std::pow(0.95, 100), 1e-4);
}

TEST(ScreenLobeFit, EqualSamplesGiveTheNarrowestLobeThatIsAllowed)
{
    const std::vector<PlacedSample> samples(50, {{0.3, 0.7}, 2.0});
    const ScreenLobe sharp = fit(SCREEN_LOBE_GAUSSIAN, samples, 0, 0),
                     soft = fit(SCREEN_LOBE_GAUSSIAN, samples, 0, 1e-3f);
    EXPECT_NEAR(sharp.spread.x, 0.01, 1e-5);
    EXPECT_NEAR(sharp.spread.z, 0.01, 1e-4);
    EXPECT_NEAR(soft.spread.x, std::sqrt(1e-3), 1e-4);
    EXPECT_NEAR(fit(SCREEN_LOBE_VMF, samples, 0, 0).spread.x, 1e4, 1);
    EXPECT_NEAR(fit(SCREEN_LOBE_VMF, samples, 0, 1e-3f).spread.x, 1 / (1e-4 + 2 * M_PI * 1e-3), 0.5);
}

TEST(ScreenLobeFit, TinyAndHugeWeightsAndNoneStayFinite)
{
    for (const double weight : {1e-38, 1e-20, 1e30}) {
        const ScreenLobe lobe = fit(SCREEN_LOBE_VMF, {{{0.3, 0.7}, weight}, {{0.4, 0.7}, weight}}, 1, 1e-3f);
        EXPECT_EQ(lobe.kind, SCREEN_LOBE_VMF);
        EXPECT_TRUE(std::isfinite(lobe.spread.x) && std::isfinite(lobe.mean.x)) << weight;
    }
    EXPECT_EQ(fit(SCREEN_LOBE_GAUSSIAN, {}, 1, 1e-3f).kind, SCREEN_LOBE_NONE);
}

}  // namespace
}  // namespace restirpg::test
