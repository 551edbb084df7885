// Do light samples have the pdf they claim, and is it the one that MIS asks for?
//
// Null hypothesis of each chi-square: the counts of 2^20 draws are multinomial with the integrals of the pdf.
// False-alarm rate: 1% over the comparisons of a test. The same comparison must reject errors made on purpose.
#include "../support/statistics.h"
#include "gpu_test.h"
#include "light_case.h"
#include "light_scenes.h"

#include <bit>
#include <cmath>
#include <memory>

namespace restirpg::test {
namespace {

constexpr uint32_t THREADS = 1u << 16;
constexpr double DRAWS = double(THREADS) * DRAWS_A_THREAD;
/// What the midpoint rule over 4096 points a bin may be off, of the whole: the edges of triangles cut bins.
constexpr double QUADRATURE_ERROR = 3e-3;

struct Drawn {
    LightCounts counts;
    double mean = 0;  ///< of luminance / pdf
    double standardError = 0;
};

Drawn sample(const UploadedScene& scene, LightCase test)
{
    const Buffer results = device().createBuffer(sizeof(LightCounts) + THREADS * sizeof(LightSums), "light counts");
    test.frame = scene.frame.address();
    test.results = results.address();
    run("light_sample", test, THREADS, &scene.gpu.bindings());
    Drawn drawn;
    device().download(results, &drawn.counts, sizeof(LightCounts));
    std::vector<LightSums> sums(THREADS);
    device().download(results, sums.data(), THREADS * sizeof(LightSums), sizeof(LightCounts));
    double square = 0;
    for (const LightSums& thread : sums) {
        drawn.mean += double(thread.radiance) / DRAWS;
        square += double(thread.square) / DRAWS;
    }
    drawn.standardError = std::sqrt(std::max(square - drawn.mean * drawn.mean, 0.0) / DRAWS);
    return drawn;
}

struct Integrals {
    std::vector<double> expected;  ///< draws a bin
    double mass = 0;
    double radiance = 0;  ///< luminance over the sphere
};

Integrals integrate(const UploadedScene& scene, LightCase test)
{
    const Buffer values = device().createBuffer(BINS * sizeof(glm::vec2), "integrals");
    test.frame = scene.frame.address();
    test.results = values.address();
    run("light_integrate", test, BINS, &scene.gpu.bindings());
    Integrals integrals;
    for (const glm::vec2& bin : device().download<glm::vec2>(values, BINS)) {
        integrals.expected.push_back(bin.x * DRAWS);
        integrals.mass += bin.x;
        integrals.radiance += bin.y;
    }
    return integrals;
}

LightCase lightCase(uint32_t technique, uint32_t error = ERROR_NONE)
{
    LightCase test{};
    test.x = glm::vec3(0.1f, -0.2f, 0.3f);
    test.technique = technique;
    test.seed = 42;
    test.error = error;
    return test;
}

ChiSquare directions(const Drawn& drawn, const Integrals& integrals)
{
    return chiSquare(drawn.counts.bins, integrals.expected);
}

// ---- Directions ----

/// A scene on the device with the integrals of its pdf, which several tests need.
struct Prepared {
    Prepared(const std::string& label, Scene source, uint32_t how)
        : name(label), scene(std::move(source)), technique(how), integrals(integrate(scene, lightCase(how)))
    {
    }

    std::string name;
    UploadedScene scene;
    uint32_t technique;
    Integrals integrals;
};

const std::vector<std::unique_ptr<Prepared>>& scenes()
{
    static const auto all = [] {
        Scene sky = darkScene();
        sky.environment = sunnySky();
        Scene constant = darkScene();
        constant.environment = Environment{.radiance = {1, 1, 1}, .texture = {}, .rotation = 0};
        Scene everything = triangleLightScene();
        addPunctualLights(everything);
        everything.environment = sunnySky();
        std::vector<std::unique_ptr<Prepared>> made;
        made.push_back(std::make_unique<Prepared>("triangles", triangleLightScene(), SAMPLE_LIGHTS));
        made.push_back(std::make_unique<Prepared>("textured emitters", signScene(), SAMPLE_LIGHTS));
        made.push_back(std::make_unique<Prepared>("sky", sky, SAMPLE_ENVIRONMENT));
        made.push_back(std::make_unique<Prepared>("constant environment", constant, SAMPLE_ENVIRONMENT));
        made.push_back(std::make_unique<Prepared>("everything", everything, SAMPLE_LIGHTS));
        return made;
    }();
    return all;
}

TEST(LightSampling, DirectionsFollowThePdf)
{
    for (const auto& entry : scenes()) {
        const ChiSquare result = directions(sample(entry->scene, lightCase(entry->technique)), entry->integrals);
        EXPECT_GT(result.p, bonferroni(scenes().size())) << entry->name << ": chi-square " << result.statistic
                                                         << " with " << result.degrees << " degrees of freedom";
    }
}

TEST(LightSampling, SamplersThatAreFivePercentUnevenAreRejected)
{
    for (const auto& entry : scenes()) {
        const Drawn drawn = sample(entry->scene, lightCase(entry->technique, ERROR_BEND));
        EXPECT_LT(directions(drawn, entry->integrals).p, bonferroni(scenes().size())) << entry->name;
    }
}

TEST(LightSampling, ThePdfIntegratesToTheShareOfLightsThatScatteringCanFind)
{
    for (const auto& entry : scenes()) {
        double share = 1;
        if (entry->technique == SAMPLE_LIGHTS)
            for (const Light& light : entry->scene.gpu.lights().lights)
                share -= light.type == LIGHT_POINT || light.type == LIGHT_SPOT || light.type == LIGHT_DIRECTIONAL
                             ? light.pmf
                             : 0;
        EXPECT_NEAR(entry->integrals.mass, share, QUADRATURE_ERROR) << entry->name;
        const double wrong = integrate(entry->scene, lightCase(entry->technique, ERROR_PDF)).mass;
        EXPECT_GT(std::abs(wrong - share), QUADRATURE_ERROR) << entry->name << ": a pdf that is 2% too large must fail";
    }
}

TEST(LightSampling, RadianceOverPdfAveragesToTheIntegralOfRadiance)
{
    for (const auto& entry : scenes()) {
        const Drawn drawn = sample(entry->scene, lightCase(entry->technique));
        const double expected = entry->integrals.radiance;
        EXPECT_NEAR(drawn.mean, expected, 4.5 * drawn.standardError + QUADRATURE_ERROR * expected) << entry->name;
    }
}

/// Of points on triangles: the environment's samples ask the function that MIS asks.
TEST(LightSampling, MisAsksForTheSamePdfThatTheSampleHas)
{
    const auto worst = [](const Prepared& entry, uint32_t error) {
        return std::bit_cast<float>(sample(entry.scene, lightCase(SAMPLE_LIGHTS, error)).counts.worstPdf);
    };
    for (const auto& entry : scenes())
        if (entry->technique == SAMPLE_LIGHTS) {
            EXPECT_LT(worst(*entry, ERROR_NONE), 1e-4f) << entry->name;
            EXPECT_GT(worst(*entry, ERROR_PDF), 1e-2f) << entry->name << ": a pdf that is 2% too large must fail";
        }
}

// ---- Selection ----

/// Chi-square of how often each light of the scene was drawn.
ChiSquare selection(const UploadedScene& scene, uint32_t error)
{
    const Drawn drawn = sample(scene, lightCase(SAMPLE_LIGHTS, error));
    std::vector<double> expected;
    for (const Light& light : scene.gpu.lights().lights)
        expected.push_back(double(light.pmf) * DRAWS);
    return chiSquare({drawn.counts.lights, expected.size()}, expected);
}

TEST(LightSampling, LightsAreSelectedByTheirProbability)
{
    Scene source = triangleLightScene();
    addPunctualLights(source);
    const UploadedScene scene(source);
    EXPECT_GT(selection(scene, ERROR_NONE).p, bonferroni(1));
    EXPECT_LT(selection(scene, ERROR_BEND).p, 1e-6);
}

/// What cells and stored positions are measured by stands still while nodes move about the scene, and follows when they
/// leave it; powers follow every pose.
TEST(LightSampling, TheSceneIsMeasuredAgainWhenItsNodesLeaveIt)
{
    Scene source = triangleLightScene();
    addPunctualLights(source);
    UploadedScene scene(source);
    const auto pose = poseNodes(scene.scene, 0);
    const SceneTable first = scene.gpu.table();
    const auto directional = [&] {
        for (const Light& light : scene.gpu.lights().lights)
            if (light.type == LIGHT_DIRECTIONAL)
                return light.pmf;
        return 0.0f;
    };
    const auto moveFirst = [&](float distance) {
        auto moved = pose;
        moved[scene.scene.instances[0].node][3].x += distance;
        scene.gpu.update(moved, &pose);
    };
    const float before = directional();
    moveFirst(0.5f * first.radius);
    EXPECT_EQ(scene.gpu.table().radius, first.radius);
    EXPECT_EQ(scene.gpu.table().center, first.center);
    EXPECT_GT(directional(), before) << "its disk has grown";
    moveFirst(10 * first.radius);
    EXPECT_GT(scene.gpu.table().radius, 4 * first.radius);
    EXPECT_GT(scene.gpu.table().center.x, first.center.x + 4 * first.radius);
    moveFirst(0);
    EXPECT_LT(scene.gpu.table().radius, 1.01f * first.radius) << "it has shrunk to less than a quarter";
    EXPECT_EQ(directional(), before);
}

TEST(LightSampling, ASceneWithoutLightsGivesNoSample)
{
    const UploadedScene scene(darkScene());
    const Drawn drawn = sample(scene, lightCase(SAMPLE_LIGHTS));
    EXPECT_EQ(drawn.counts.empty, uint32_t(DRAWS));
}

}  // namespace
}  // namespace restirpg::test
