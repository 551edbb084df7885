// ErrorMeasure against measureErrors, the same figures in double precision on the host.
#include "pass_harness.h"

#include "image/metrics.h"

#include "../../passes/ErrorMeasure/Shared.h"

#include <cmath>
#include <filesystem>
#include <limits>
#include <random>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

constexpr uint32_t WIDTH = 67;  // more pixels than lanes, and no multiple of them
constexpr uint32_t HEIGHT = 41;
constexpr double TOLERANCE = 1e-5;

/// A seeded image of values spread over five orders of magnitude.
Image noise(uint32_t seed)
{
    std::mt19937 random(seed);
    std::lognormal_distribution<float> value(0.0f, 2.0f);
    Image image{WIDTH, HEIGHT, 3, std::vector<float>(WIDTH * HEIGHT * 3)};
    for (float& v : image.data)
        v = value(random);
    return image;
}

class ErrorMeasureTest : public testing::Test {
protected:
    ErrorMeasureTest()
    {
        file_ = fs::temp_directory_path() / ("restirpg-reference-" + std::to_string(getpid()) + ".exr");
    }
    ~ErrorMeasureTest() override { fs::remove(file_); }

    MeasuredErrors measure(const Image& image, const Image& reference)
    {
        writeExr(file_, {{"", reference}}, PixelType::full);
        image_ = pass_.device().createBuffer(image.data, "image");
        map_ = pass_.makeBuffer("map");
        errors_ = pass_.makeBuffer("errors");
        pass_.connect("image", &image_);
        pass_.connect("map", &map_);
        pass_.connect("errors", &errors_);
        pass_.setKnob("reference", file_.string());
        pass_.build();
        pass_.run(1);
        return pass_.download<MeasuredErrors>(errors_)[0];
    }

    void expectAgreement(const MeasuredErrors& device, const Errors& host)
    {
        EXPECT_NEAR(device.mape / host.mape, 1, TOLERANCE);
        EXPECT_NEAR(device.relMse / host.relMse, 1, TOLERANCE);
        EXPECT_NEAR(device.rmse / host.rmse, 1, TOLERANCE);
        EXPECT_NEAR(device.bias / host.bias, 1, TOLERANCE);
        EXPECT_EQ(device.invalid, host.invalid);
    }

    std::string errorOf(const std::function<void()>& action)
    {
        try {
            action();
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }

    fs::path file_;
    PassHarness pass_{"ErrorMeasure", WIDTH, HEIGHT};
    Buffer image_, map_, errors_;
};

TEST_F(ErrorMeasureTest, DeviceAndHostAgreeOnUnrelatedImages)
{
    const Image image = noise(1), reference = noise(2);
    expectAgreement(measure(image, reference), measureErrors(image, reference));
}

TEST_F(ErrorMeasureTest, ABiasOfOnePartInAMillionIsResolved)
{
    Image image = noise(3);
    const Image reference = image;
    std::mt19937 random(4);
    for (float& v : image.data)
        v *= random() % 2 ? 1.001f : 0.999002f;
    const Errors host = measureErrors(image, reference);
    ASSERT_LT(std::abs(host.bias), 1e-4);
    expectAgreement(measure(image, reference), host);
}

TEST_F(ErrorMeasureTest, InvalidPixelsOfEitherImageAreLeftOutAndCounted)
{
    Image image = noise(5), reference = noise(6);
    image.data[100] = std::numeric_limits<float>::quiet_NaN();
    image.data[2000] = std::numeric_limits<float>::infinity();
    reference.data[5000] = -std::numeric_limits<float>::infinity();
    const MeasuredErrors device = measure(image, reference);
    EXPECT_EQ(device.invalid, 3u);
    expectAgreement(device, measureErrors(image, reference));
}

TEST_F(ErrorMeasureTest, TheMapsMeanIsTheMape)
{
    const Image image = noise(7), reference = noise(8);
    const MeasuredErrors device = measure(image, reference);
    double sum = 0;
    for (float term : pass_.download<float>(map_))
        sum += term;
    EXPECT_NEAR(sum / (WIDTH * HEIGHT) / device.mape, 1, TOLERANCE);
}

TEST_F(ErrorMeasureTest, EqualImagesHaveNoErrorEvenWhereBlack)
{
    Image image = noise(9);
    std::fill(image.data.begin(), image.data.begin() + 300, 0.0f);
    const MeasuredErrors device = measure(image, image);
    EXPECT_EQ(device.mape, 0);
    EXPECT_EQ(device.relMse, 0);
    EXPECT_EQ(device.rmse, 0);
    EXPECT_EQ(device.bias, 0);
}

TEST_F(ErrorMeasureTest, WithoutAValidPixelTheFiguresAreNaN)
{
    Image image = noise(10);
    std::fill(image.data.begin(), image.data.end(), std::numeric_limits<float>::quiet_NaN());
    const MeasuredErrors device = measure(image, noise(11));
    EXPECT_TRUE(std::isnan(device.mape) && std::isnan(device.relMse) && std::isnan(device.rmse) &&
                std::isnan(device.bias));
    EXPECT_EQ(device.invalid, WIDTH * HEIGHT);
}

TEST_F(ErrorMeasureTest, AMissingOrMismatchedReferenceIsOneClearError)
{
    EXPECT_EQ(errorOf([&] { pass_.build(); }),
              "it needs a reference: set its knob 'reference' to the path of an EXR file");
    Image small = noise(12);
    small.height -= 1;
    small.data.resize(WIDTH * small.height * 3);
    EXPECT_EQ(errorOf([&] { measure(noise(13), small); }),
              file_.string() + ": the reference is 67x40 but the image is 67x41; render at the reference's size");
}

TEST_F(ErrorMeasureTest, AFireflyBeyondTheSquaresOfFloatsIsAnErrorAndNoNaN)
{
    Image image{WIDTH, HEIGHT, 3, std::vector<float>(WIDTH * HEIGHT * 3, 0.5f)};
    const Image reference = image;
    image.data[100] = 2e19f;
    const MeasuredErrors errors = measure(image, reference);
    const Errors host = measureErrors(image, reference);
    EXPECT_NEAR(errors.mape / host.mape, 1, TOLERANCE);
    EXPECT_EQ(errors.invalid, 0u);
    EXPECT_GT(errors.rmse, 1e12f);
    EXPECT_LT(errors.rmse, host.rmse);
    EXPECT_GT(errors.relMse, 1e25f);
}

}  // namespace
}  // namespace restirpg
