// What control groups leave of the memory, on made-up ones.
#include "core/memory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>

#include <unistd.h>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

class Groups : public testing::Test {
protected:
    Groups() { fs::create_directories(root_); }
    ~Groups() override { fs::remove_all(root_); }

    void write(const fs::path& file, const std::string& text) const
    {
        fs::create_directories((root_ / file).parent_path());
        std::ofstream(root_ / file) << text << "\n";
    }
    uint64_t left(const std::string& membership) const
    {
        std::istringstream stream(membership);
        return groupMemoryLeft(root_, stream);
    }

    const fs::path root_ = fs::temp_directory_path() / ("restirpg_groups_" + std::to_string(getpid()));
};

TEST_F(Groups, LeaveWhatCachedFilesTake)
{
    EXPECT_EQ(left("0::/job\n"), UINT64_MAX);
    write("job/memory.max", "1000");
    write("job/memory.current", "900");
    EXPECT_EQ(left("0::/job\n"), 100u);
    write("job/memory.stat", "anon 300\nfile 600\ninactive_file 400\nactive_file 150");
    EXPECT_EQ(left("0::/job\n"), 650u);
    write("job/memory.stat", "inactive_file 5000");
    EXPECT_EQ(left("0::/job\n"), 1000u);
}

TEST_F(Groups, LeaveNoMoreThanThoseAboveThem)
{
    write("slice/memory.max", "500");
    write("slice/memory.current", "200");
    write("slice/job/memory.max", "max");
    EXPECT_EQ(left("0::/slice/job\n"), 300u);
    write("memory.max", "250");
    EXPECT_EQ(left("0::/slice/job\n"), 250u);
    EXPECT_EQ(left("0::/../elsewhere\n"), 250u);
}

TEST_F(Groups, OfVersion1AreRead)
{
    write("memory/memory.limit_in_bytes", "9223372036854771712");
    write("memory/job/memory.limit_in_bytes", "1000");
    write("memory/job/memory.usage_in_bytes", "900");
    write("memory/job/memory.stat", "inactive_file 1\ntotal_inactive_file 200\ntotal_active_file 100");
    EXPECT_EQ(left("4:memory:/job\n1:cpu:/\n0::/\n"), 400u);
}

}  // namespace
}  // namespace restirpg
