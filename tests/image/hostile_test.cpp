// Damaged and hostile image files end in one Error each: no crash, no endless loop, no giant allocation.
#include "fixture.h"

#include <sys/resource.h>

#include <cstring>
#include <random>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

class HostileImage : public FolderTest {
protected:
    /// Every allocation beyond 1 GB more than the process has now fails, and with it the test.
    void SetUp() override
    {
        FolderTest::SetUp();
        getrlimit(RLIMIT_AS, &before_);
        std::ifstream statm("/proc/self/statm");
        rlim_t pages = 0;
        statm >> pages;
        const rlimit limited{pages * rlim_t(getpagesize()) + (rlim_t(1) << 30), before_.rlim_max};
        setrlimit(RLIMIT_AS, &limited);
    }
    void TearDown() override
    {
        setrlimit(RLIMIT_AS, &before_);
        FolderTest::TearDown();
    }

    fs::path exr()
    {
        writeExr(folder_ / "good.exr", {{"", ramp(20, 37, 3)}, {"depth", ramp(20, 37, 1)}}, PixelType::half,
                 {{"graph", "{}"}, {"seed", "1"}});
        return folder_ / "good.exr";
    }

    /// Reads the file; its Error must name it, say what to do, and be one line.
    template <typename Read>
    bool isReadOrOneError(const fs::path& file, Read&& read)
    {
        const std::string error = errorOf([&] { read(file); });
        if (error.empty())
            return true;
        EXPECT_EQ(error.rfind(file.string() + ": cannot read", 0), 0u) << error;
        EXPECT_EQ(error.find('\n'), std::string::npos) << error;
        EXPECT_EQ(error.find("bad_alloc"), std::string::npos) << error;
        return false;
    }

private:
    rlimit before_{};
};

/// Seeded damage: bits flipped, bytes replaced by extreme ones, a piece cut out, or the end cut off.
std::vector<char> mutate(std::vector<char> bytes, std::mt19937& random, size_t headerBytes)
{
    const auto below = [&](size_t n) { return size_t(random() % n); };
    // Half the mutations strike the header, where sizes and counts are.
    const auto place = [&] { return random() % 2 ? below(std::min(headerBytes, bytes.size())) : below(bytes.size()); };
    switch (random() % 4) {
    case 0:
        for (size_t n = 1 + below(4); n > 0; --n)
            bytes[place()] ^= char(1u << below(8));
        break;
    case 1:
        for (size_t n = 1 + below(3); n > 0; --n)
            bytes[place()] = std::array<char, 4>{0, 1, 127, char(255)}[below(4)];
        break;
    case 2: {
        const size_t first = place();
        bytes.erase(bytes.begin() + ptrdiff_t(first),
                    bytes.begin() + ptrdiff_t(std::min(bytes.size(), first + 1 + below(40))));
        break;
    }
    default:
        bytes.resize(below(bytes.size()));
    }
    return bytes;
}

TEST_F(HostileImage, FiveHundredMutationsOfAnExrAreReadOrRefusedInOneLine)
{
    const auto bytes = readBytes(exr());
    std::mt19937 random(1);
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        SCOPED_TRACE("mutation " + std::to_string(i));
        writeBytes(folder_ / "bad.exr", mutate(bytes, random, 500));
        const bool read = isReadOrOneError(folder_ / "bad.exr", [](const fs::path& f) { return readExr(f); });
        const bool readHeader =
            isReadOrOneError(folder_ / "bad.exr", [](const fs::path& f) { return readExrAttributes(f); });
        EXPECT_LE(read, readHeader);
        refused += !read;
    }
    EXPECT_GT(refused, 200);
}

TEST_F(HostileImage, EveryTruncationOfAnExrIsRefused)
{
    const auto bytes = readBytes(exr());
    for (size_t size = 0; size < bytes.size(); size += 11) {
        SCOPED_TRACE("first bytes " + std::to_string(size));
        writeBytes(folder_ / "bad.exr", {bytes.begin(), bytes.begin() + ptrdiff_t(size)});
        EXPECT_FALSE(isReadOrOneError(folder_ / "bad.exr", [](const fs::path& f) { return readExr(f); }));
    }
}

TEST_F(HostileImage, AHugeDataWindowIsRefusedByItsClaim)
{
    const auto good = readBytes(exr());
    const std::string key("dataWindow\0box2i\0\x10\0\0\0", 21);
    const auto found = std::search(good.begin(), good.end(), key.begin(), key.end());
    ASSERT_NE(found, good.end());
    for (const auto& [right, bottom] : std::vector<std::pair<int32_t, int32_t>>{
             {30000, 30000}, {65535, 4095}, {65535, 65535}, {2147483647, 2147483647}, {-2147483647, 5}}) {
        auto bytes = good;
        char* window = bytes.data() + (found - good.begin()) + ptrdiff_t(key.size());
        std::memcpy(window + 8, &right, 4);
        std::memcpy(window + 12, &bottom, 4);
        writeBytes(folder_ / "bad.exr", bytes);
        EXPECT_FALSE(isReadOrOneError(folder_ / "bad.exr", [](const fs::path& f) { return readExr(f); })) << right;
    }
}

/// OpenEXR reads a channel list to its end and not for as long as its size says: what follows would be read elsewhere.
TEST_F(HostileImage, AnAttributeOfAnotherSizeThanItsTypeIsRefused)
{
    const auto good = readBytes(exr());
    for (const std::string& key : {std::string("channels\0chlist", 15), std::string("dataWindow\0box2i", 16)}) {
        auto bytes = good;
        const auto found = std::search(bytes.begin(), bytes.end(), key.begin(), key.end());
        ASSERT_NE(found, bytes.end());
        ++found[ptrdiff_t(key.size()) + 1];
        writeBytes(folder_ / "bad.exr", bytes);
        const std::string error = errorOf([&] { readExr(folder_ / "bad.exr"); });
        EXPECT_TRUE(contains(error, "bad.exr: cannot read: an attribute of type")) << error;
    }
}

TEST_F(HostileImage, FilesThatAreNotImagesAreRefused)
{
    for (const std::string text :
         {"", "\n", "v/1\1", "#?RADIANCE", "#?RADIANCE\n\n-Y 0 +X 0\n", "#?RADIANCE\n\n-Y 4 +X\n",
          "#?RADIANCE\n\n-Y 60000 +X 60000\n", "#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n"}) {
        writeBytes(folder_ / "bad", {text.begin(), text.end()});
        EXPECT_FALSE(isReadOrOneError(folder_ / "bad", [](const fs::path& f) { return readExr(f); })) << text;
        EXPECT_FALSE(isReadOrOneError(folder_ / "bad", [](const fs::path& f) { return readHdr(f); })) << text;
    }
    for (const fs::path& file : {folder_ / "missing", folder_, fs::path("/dev/zero"), fs::path("/dev/full")}) {
        EXPECT_FALSE(isReadOrOneError(file, [](const fs::path& f) { return readExr(f); }));
        EXPECT_FALSE(isReadOrOneError(file, [](const fs::path& f) { return readHdr(f); }));
    }
}

TEST_F(HostileImage, FiveHundredMutationsOfAnHdrAreReadOrRefusedInOneLine)
{
    std::string text = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 10\n";
    for (int row = 0; row < 4; ++row) {
        text += std::string("\2\2\0\12", 4);
        for (int component = 0; component < 4; ++component)
            text += std::string("\x85\x40\5abcde", 8);
    }
    std::mt19937 random(2);
    int refused = 0;
    for (int i = 0; i < 500; ++i) {
        SCOPED_TRACE("mutation " + std::to_string(i));
        writeBytes(folder_ / "bad.hdr", mutate({text.begin(), text.end()}, random, 48));
        refused += !isReadOrOneError(folder_ / "bad.hdr", [](const fs::path& f) { return readHdr(f); });
    }
    EXPECT_GT(refused, 200);
    EXPECT_LT(refused, 500);
}

}  // namespace
}  // namespace restirpg
