// Random numbers by address, and the maps from them.
//
// Null hypothesis: pairs of numbers, of one address or of neighbouring ones, are uniform on the unit square (2^20 pairs
// in 32 x 32 cells). False-alarm rate: 1% over all pairs and walks (Bonferroni).
#include "../support/statistics.h"
#include "gpu_test.h"
#include "random_case.h"
#include "sampling_case.h"

#include <bit>
#include <set>

namespace restirpg::test {
namespace {

constexpr uint32_t NUMBERS = 1u << 20;
constexpr uint32_t REUSE_ROUNDS = 8;  // the knob's most

RandomCounts draw(uint32_t walk, uint32_t seed, bool weak)
{
    const Buffer results = device().createBuffer(sizeof(RandomCounts), "random counts");
    run("random", RandomCase{results.address(), walk, seed, weak}, NUMBERS);
    RandomCounts counts;
    device().download(results, &counts, sizeof(counts));
    return counts;
}

/// The smallest p of the four pair histograms of a walk.
double smallestP(const RandomCounts& counts)
{
    const std::vector<double> expected(GRID * GRID, double(NUMBERS) / (GRID * GRID));
    double p = 1;
    for (uint32_t pair = 0; pair < PAIRS; ++pair)
        p = std::min(p, chiSquare(std::span(counts.cells).subspan(pair * GRID * GRID, GRID * GRID), expected).p);
    return p;
}

TEST(Random, NumbersAreUniformAlongEveryCoordinateOfTheirAddress)
{
    constexpr std::array SEEDS{0u, 1u, 0x9e3779b9u};
    for (uint32_t walk = 0; walk < WALKS; ++walk)
        for (const uint32_t seed : SEEDS) {
            const RandomCounts counts = draw(walk, seed, false);
            EXPECT_GT(smallestP(counts), bonferroni(WALKS * PAIRS * SEEDS.size()))
                << "walk " << walk << ", seed " << seed;
            EXPECT_EQ(counts.outside, 0u);
        }
}

TEST(Random, AHashWithoutItsSecondHalfIsRejected)
{
    for (uint32_t walk = 0; walk < WALKS; ++walk)
        EXPECT_LT(smallestP(draw(walk, 0, true)), 1e-6) << "walk " << walk;
}

/// How many different numbers the most rounds of reuse take.
size_t differentReuseNumbers(bool overlapping)
{
    constexpr uint32_t COUNT = REUSE_NUMBERS * (REUSE_ROUNDS + 1);
    const Buffer results = device().createBuffer(COUNT * sizeof(glm::vec2), "numbers of reuse");
    run("reuse_numbers", ReuseNumbersCase{results.address(), REUSE_ROUNDS, overlapping}, COUNT);
    std::vector<std::pair<float, float>> numbers(COUNT);
    device().download(results, numbers.data(), results.bytes());
    return std::set(numbers.begin(), numbers.end()).size();
}

TEST(Random, RoundsOfReuseShareNoNumber)
{
    EXPECT_EQ(differentReuseNumbers(false), REUSE_NUMBERS * (REUSE_ROUNDS + 1));
    EXPECT_LT(differentReuseNumbers(true), REUSE_NUMBERS * (REUSE_ROUNDS + 1));
}

TEST(Random, TheSameAddressGivesTheSameNumber)
{
    const RandomCounts first = draw(WALK_FRAME, 5, false);
    const RandomCounts second = draw(WALK_FRAME, 5, false);
    EXPECT_TRUE(std::equal(std::begin(first.cells), std::end(first.cells), std::begin(second.cells)));
    const RandomCounts other = draw(WALK_FRAME, 6, false);
    EXPECT_FALSE(std::equal(std::begin(first.cells), std::end(first.cells), std::begin(other.cells)));
}

TEST(Sampling, FramesAreOrthonormalAndAliasDrawsExact)
{
    const Buffer results = device().createBuffer(sizeof(SamplingWorst), "worst");
    run("sampling", SamplingCase{results.address()}, NUMBERS);
    SamplingWorst worst;
    device().download(results, &worst, sizeof(worst));
    EXPECT_LT(std::bit_cast<float>(worst.basis), 3e-6f);
    EXPECT_LT(std::bit_cast<float>(worst.roundTrip), 3e-6f);
    EXPECT_LT(std::bit_cast<float>(worst.cosineLength), 2e-6f);
    EXPECT_LT(std::bit_cast<float>(worst.alias), 2e-7f);
}

}  // namespace
}  // namespace restirpg::test
