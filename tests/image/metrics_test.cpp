// The error metrics against figures worked out by hand.
#include "fixture.h"

#include "image/metrics.h"

#include <cmath>
#include <limits>

namespace restirpg {
namespace {

/// Two pixels: a coloured one and a grey one.
const Image REFERENCE{2, 1, 3, {1, 2, 3, 4, 4, 4}};
const Image IMAGE{2, 1, 3, {2, 2, 1, 4, 5, 4}};

TEST(Metrics, MapeDividesByTheLuminanceOfThePixelAndOnePercentOfTheMean)
{
    // Y = 0.2126 + 1.4304 + 0.2166 = 1.8596 and 4; mean 2.9298; |I - R| = 1, 0, 2 and 0, 1, 0.
    const double expected = (3.0 / (0.029298 + 1.8596) + 1.0 / (0.029298 + 4.0)) / 6.0;
    EXPECT_NEAR(measureErrors(IMAGE, REFERENCE).mape, expected, 1e-12);
}

TEST(Metrics, RelativeSquaredErrorDividesByTheChannelsOwnSquare)
{
    const double expected = (1.0 / 1.01 + 0.0 + 4.0 / 9.01 + 0.0 + 1.0 / 16.01 + 0.0) / 6.0;
    EXPECT_NEAR(measureErrors(IMAGE, REFERENCE).relMse, expected, 1e-12);
}

TEST(Metrics, RmseAndSignedBiasAreOverPixelsAndChannels)
{
    // Squares 1 + 4 + 1; differences +1 - 2 + 1 = 0, then with the last channel raised by 3, +3 over a total of 18.
    EXPECT_NEAR(measureErrors(IMAGE, REFERENCE).rmse, 1.0, 1e-12);
    EXPECT_NEAR(measureErrors(IMAGE, REFERENCE).bias, 0.0, 1e-12);
    Image brighter = IMAGE;
    brighter.data[5] += 3;
    EXPECT_NEAR(measureErrors(brighter, REFERENCE).bias, 3.0 / 18.0, 1e-12);
}

TEST(Metrics, MetricsAreNotSymmetric)
{
    EXPECT_GT(std::abs(measureErrors(IMAGE, REFERENCE).mape - measureErrors(REFERENCE, IMAGE).mape), 1e-3);
}

TEST(Metrics, InvalidPixelsOfEitherImageAreCountedAndLeftOutOfEveryMean)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    Image image = IMAGE, reference = REFERENCE;
    image.width = reference.width = 4;
    image.data.insert(image.data.end(), {nan, 1, 1, 7, 7, 7});
    reference.data.insert(reference.data.end(), {1, 1, 1, 7, infinity, 7});
    const Errors with = measureErrors(image, reference);
    const Errors without = measureErrors(IMAGE, REFERENCE);
    EXPECT_EQ(with.invalid, 2u);
    EXPECT_EQ(without.invalid, 0u);
    EXPECT_DOUBLE_EQ(with.mape, without.mape);
    EXPECT_DOUBLE_EQ(with.relMse, without.relMse);
    EXPECT_DOUBLE_EQ(with.rmse, without.rmse);
    EXPECT_DOUBLE_EQ(with.bias, without.bias);
}

TEST(Metrics, BlackIsWithoutErrorAgainstBlackAndInfinitelyWrongOtherwise)
{
    const Image black = constant(2, 2, {0, 0, 0});
    const Errors same = measureErrors(black, black);
    EXPECT_EQ(same.mape, 0.0);
    EXPECT_EQ(same.bias, 0.0);
    EXPECT_TRUE(std::isinf(measureErrors(constant(2, 2, {1, 1, 1}), black).mape));
}

TEST(Metrics, WithoutAValidPixelTheFiguresAreNaN)
{
    const Errors errors = measureErrors(constant(2, 3, {1, 1, std::nanf("")}), constant(2, 3, {1, 1, 1}));
    EXPECT_EQ(errors.invalid, 6u);
    EXPECT_TRUE(std::isnan(errors.mape) && std::isnan(errors.relMse) && std::isnan(errors.rmse) &&
                std::isnan(errors.bias));
}

TEST(Metrics, AFireflyOfAnyFiniteSizeStaysFinite)
{
    Image image = REFERENCE;
    image.data[0] = std::numeric_limits<float>::max();
    const Errors errors = measureErrors(image, REFERENCE);
    EXPECT_TRUE(std::isfinite(errors.mape) && std::isfinite(errors.relMse) && std::isfinite(errors.rmse));
}

TEST(Metrics, DifferentShapesAreAnError)
{
    EXPECT_TRUE(
        contains(errorOf([] { measureErrors(ramp(2, 2, 3), ramp(2, 3, 3)); }), "a 2x2 image with a 2x3 reference"));
    EXPECT_TRUE(contains(errorOf([] { measureErrors(ramp(2, 2, 1), ramp(2, 2, 3)); }), "1 and 3 channels"));
}

}  // namespace
}  // namespace restirpg
