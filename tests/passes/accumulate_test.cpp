// Accumulate against sums in 80-bit floats on the host.
#include "pass_harness.h"

#include <array>
#include <cmath>
#include <limits>
#include <random>

namespace restirpg {
namespace {

constexpr uint32_t WIDTH = 11;  // not a multiple of the group's 8
constexpr uint32_t HEIGHT = 3;
constexpr uint32_t PIXELS = WIDTH * HEIGHT;
constexpr uint32_t VALUES = 3 * PIXELS;

using Values = std::vector<float>;

struct HostSums {
    std::vector<long double> sum = std::vector<long double>(VALUES), squares = sum;
    uint32_t count = 0;

    void add(const Values& frame)
    {
        for (uint32_t i = 0; i < VALUES; ++i) {
            sum[i] += frame[i];
            squares[i] += (long double)frame[i] * frame[i];
        }
        ++count;
    }
    double mean(uint32_t i) const { return double(sum[i] / count); }
    double variance(uint32_t i) const { return double((squares[i] - sum[i] * sum[i] / count) / (count - 1)); }
};

class AccumulateTest : public testing::Test {
protected:
    void SetUp() override
    {
        for (const char* port : {"mean", "variance", "invalid"})
            pass_.connect(port, &(outputs_[port] = pass_.makeBuffer(port)));
        for (Buffer& state : states_)
            state = pass_.makeBuffer("sums");
        pass_.build();
    }

    Buffer upload(const Values& values) { return pass_.device().createBuffer(values, "values"); }

    /// Run the frames in order, `rounds` times over. The states alternate, as a delayed edge makes them.
    void accumulate(const std::vector<Values>& frames, uint32_t rounds = 1)
    {
        std::vector<Buffer> buffers;
        for (const Values& frame : frames)
            buffers.push_back(upload(frame));
        for (uint32_t round = 0; round < rounds; ++round)
            pass_.run(uint32_t(frames.size()), [&](uint32_t frame) {
                pass_.connect("direct", &buffers[frame]);
                pass_.connect("history", &states_[frames_ % 2]);
                pass_.connect("sums", &states_[(frames_ + 1) % 2]);
                ++frames_;
            });
    }

    Values output(const std::string& port) { return pass_.download<float>(outputs_[port]); }

    PassHarness pass_{"Accumulate", WIDTH, HEIGHT};
    std::map<std::string, Buffer> outputs_;
    std::array<Buffer, 2> states_;
    uint32_t frames_ = 0;
};

Values constantValues(float value)
{
    return Values(VALUES, value);
}

/// Seeded frames whose values spread over nine orders of magnitude, like fireflies.
std::vector<Values> heavyTailedFrames(uint32_t count)
{
    std::mt19937 random(1);
    std::lognormal_distribution<float> tails(0.0f, 3.0f);
    std::vector<Values> frames(count, Values(VALUES));
    for (Values& frame : frames)
        for (float& value : frame)
            value = tails(random);
    return frames;
}

/// A float division follows the sums, within 2.5 units in the last place (2^-24) in Vulkan; the sum's own rounding is
/// half a unit.
constexpr double TOLERANCE = 3.0 / (1 << 23);

TEST_F(AccumulateTest, MeanAndVarianceAreExactOverAHundredThousandFrames)
{
    constexpr uint32_t DISTINCT = 200, ROUNDS = 500;
    const auto frames = heavyTailedFrames(DISTINCT);
    HostSums host;
    Values plain(VALUES);
    for (uint32_t round = 0; round < ROUNDS; ++round)
        for (const Values& frame : frames) {
            host.add(frame);
            std::transform(plain.begin(), plain.end(), frame.begin(), plain.begin(), std::plus());
        }
    accumulate(frames, ROUNDS);

    const Values mean = output("mean"), variance = output("variance");
    double worstPlain = 0;
    for (uint32_t i = 0; i < VALUES; ++i) {
        ASSERT_NEAR(mean[i] / host.mean(i), 1, TOLERANCE) << i;
        // Each squared deviation is rounded to a float before it is summed exactly.
        ASSERT_NEAR(variance[i] / host.variance(i), 1, 2 * TOLERANCE) << i;
        worstPlain = std::max(worstPlain, std::abs(plain[i] / double(host.sum[i]) - 1));
    }
    // Sums in single floats would fail by far.
    EXPECT_GT(worstPlain, 20 * TOLERANCE);
}

TEST_F(AccumulateTest, SmallVarianceOnALargeMeanIsNotLost)
{
    // Values 4096 and 4096 + 2^-11 in turn: mean 4096 + 2^-12, sample variance 2^-24 n / (n - 1) for n = 1000.
    std::vector<Values> frames = {constantValues(4096.0f), constantValues(4096.0f + 0x1p-11f)};
    accumulate(frames, 500);
    for (float value : output("variance"))
        ASSERT_NEAR(value, 0x1p-24 * 1000 / 999, 0x1p-24 * TOLERANCE);
}

TEST_F(AccumulateTest, AConstantImageHasItsValueAndNoVariance)
{
    accumulate({constantValues(0.1f)}, 1000);
    EXPECT_EQ(output("mean"), constantValues(0.1f));
    EXPECT_EQ(output("variance"), constantValues(0.0f));
}

TEST_F(AccumulateTest, TheFirstFrameIsItsOwnMeanWithoutVariance)
{
    const auto frame = heavyTailedFrames(1);
    accumulate(frame);
    EXPECT_EQ(output("mean"), frame[0]);
    EXPECT_EQ(output("variance"), constantValues(0.0f));
}

TEST_F(AccumulateTest, TheThreeInputsAreAddedToOneValueAFrame)
{
    Buffer indirect = upload(constantValues(2)), emission = upload(constantValues(4));
    pass_.connect("indirect", &indirect);
    pass_.connect("emission", &emission);
    accumulate({constantValues(1), constantValues(3)});
    EXPECT_EQ(output("mean"), constantValues(8));
    // 7 and 9: the sum's variance, not the sum of the inputs' squares.
    EXPECT_EQ(output("variance"), constantValues(2));
}

TEST_F(AccumulateTest, InvalidPixelsAreDroppedFromTheEstimateAndCounted)
{
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinity = std::numeric_limits<float>::infinity();
    Values broken = constantValues(5);
    broken[0] = nan;  // pixel 0, red
    broken[4] = infinity;  // pixel 1, green
    broken[8] = -infinity;  // pixel 2, blue
    broken[9] = 1.1e30f;  // pixel 3: beyond the largest value that is taken
    accumulate({constantValues(1), broken, broken, constantValues(3)});
    const Values mean = output("mean"), variance = output("variance"), invalid = output("invalid");
    for (uint32_t pixel = 0; pixel < PIXELS; ++pixel) {
        const bool hit = pixel < 4;
        EXPECT_EQ(invalid[pixel], hit ? 2.0f : 0.0f);
        for (uint32_t c = 0; c < 3; ++c) {
            EXPECT_EQ(mean[3 * pixel + c], hit ? 2.0f : 3.5f) << pixel;
            EXPECT_NEAR(variance[3 * pixel + c], hit ? 2.0 : 11.0 / 3.0, 1e-6) << pixel;
        }
    }
}

TEST_F(AccumulateTest, WithoutAValidFrameTheMeanIsZero)
{
    accumulate({constantValues(std::numeric_limits<float>::quiet_NaN())}, 3);
    EXPECT_EQ(output("mean"), constantValues(0));
    EXPECT_EQ(output("variance"), constantValues(0));
    EXPECT_EQ(output("invalid"), Values(PIXELS, 3));
}

TEST_F(AccumulateTest, LargeFiniteValuesStayFinite)
{
    std::vector<Values> frames(100, constantValues(0));
    frames[50] = constantValues(1e16f);
    accumulate(frames, 1000);
    HostSums host;
    for (uint32_t round = 0; round < 1000; ++round)
        for (const Values& frame : frames)
            host.add(frame);
    const Values mean = output("mean"), variance = output("variance");
    EXPECT_NEAR(mean[0] / host.mean(0), 1, TOLERANCE);
    EXPECT_NEAR(variance[0] / host.variance(0), 1, 2 * TOLERANCE);
}

TEST_F(AccumulateTest, TheMeanHoldsUpToTheLimitAndTheVarianceStops)
{
    accumulate({constantValues(1e30f), constantValues(-5e29f), constantValues(0), constantValues(1.1e30f)}, 1000);
    const Values mean = output("mean"), variance = output("variance");
    EXPECT_NEAR(mean[0] / (5e29 / 3), 1, TOLERANCE);
    EXPECT_NEAR(variance[0] / (1e38 / 2999), 1, TOLERANCE);
    EXPECT_EQ(output("invalid"), Values(PIXELS, 1000));
}

}  // namespace
}  // namespace restirpg
