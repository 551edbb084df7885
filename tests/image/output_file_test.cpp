// Files appear whole or not at all, whatever stops the writing.
#include "fixture.h"

#include "core/output_file.h"

#include <sys/mount.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <climits>
#include <random>

namespace restirpg {
namespace {

namespace fs = std::filesystem;

const std::vector<char> OLD = {'o', 'l', 'd'};

/// No file of this process may grow beyond `bytes` while this lives.
class FileSizeLimit {
public:
    explicit FileSizeLimit(rlim_t bytes)
    {
        getrlimit(RLIMIT_FSIZE, &before_);
        const rlimit limited{bytes, before_.rlim_max};
        setrlimit(RLIMIT_FSIZE, &limited);
    }
    ~FileSizeLimit() { setrlimit(RLIMIT_FSIZE, &before_); }

private:
    rlimit before_{};
};

class Output : public FolderTest {
protected:
    fs::path old(const std::string& name)
    {
        writeBytes(folder_ / name, OLD);
        return folder_ / name;
    }
    static std::string host()
    {
        char name[HOST_NAME_MAX + 1] = {};
        gethostname(name, HOST_NAME_MAX);
        return name;
    }
};

TEST_F(Output, AFileBeyondTheLimitIsAnErrorAndTheOldOneStays)
{
    const auto file = old("a.txt");
    const FileSizeLimit limit(1000);
    const std::string error = errorOf([&] { writeFile(file, std::string(1001, 'x')); });
    EXPECT_TRUE(contains(error, "a.txt: cannot write: File too large; raise the limit")) << error;
    EXPECT_EQ(readBytes(file), OLD);
    EXPECT_EQ(filesInFolder(), 1u);
    writeFile(file, std::string(1000, 'x'));
    EXPECT_EQ(readBytes(file).size(), 1000u);
}

/// OpenEXR writes its table of rows in a destructor and swallows what fails there.
TEST_F(Output, AnExrThatEndsAtAnyByteIsAnErrorAndTheOldOneStays)
{
    const auto write = [&](const fs::path& file) { writeExr(file, {{"", ramp(8, 8, 3)}}, PixelType::full); };
    write(folder_ / "whole.exr");
    const size_t size = readBytes(folder_ / "whole.exr").size();
    const auto file = old("a.exr");
    for (size_t bytes = 0; bytes < size; ++bytes) {
        const FileSizeLimit limit(bytes);
        EXPECT_TRUE(contains(errorOf([&] { write(file); }), "a.exr: cannot write: File too large")) << bytes;
        ASSERT_EQ(readBytes(file), OLD) << bytes;
    }
    EXPECT_EQ(filesInFolder(), 2u);
}

TEST_F(Output, APngBeyondTheLimitIsAnErrorAndTheOldOneStays)
{
    const auto file = old("a.png");
    const FileSizeLimit limit(40);
    const std::string error = errorOf([&] { writePng(file, ramp(8, 8, 3)); });
    EXPECT_TRUE(contains(error, "a.png: cannot write: File too large")) << error;
    EXPECT_EQ(readBytes(file), OLD);
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(Output, AFullDiskIsAnErrorAndTheOldFileStays)
{
    if (mount("tmpfs", folder_.c_str(), "tmpfs", 0, "size=64k") != 0)
        GTEST_SKIP() << "a full disk needs a small tmpfs, which only root can mount: none is written to";
    const auto exr = old("a.exr"), png = old("a.png");
    Image noise{200, 200, 3, {}};
    std::mt19937 random(1);
    for (uint32_t i = 0; i < 200 * 200 * 3; ++i)
        noise.data.push_back(float(random() >> 8) / float(1 << 24));
    const std::string exrError = errorOf([&] { writeExr(exr, {{"", noise}}, PixelType::full); });
    const std::string pngError = errorOf([&] { writePng(png, noise); });
    EXPECT_TRUE(contains(exrError, "a.exr: cannot write: No space left on device; free some space")) << exrError;
    EXPECT_TRUE(contains(pngError, "a.png: cannot write: No space left on device; free some space")) << pngError;
    EXPECT_EQ(readBytes(exr), OLD);
    EXPECT_EQ(readBytes(png), OLD);
    EXPECT_EQ(filesInFolder(), 2u);
    umount(folder_.c_str());
}

TEST_F(Output, WithoutCommitNothingIsLeft)
{
    const auto file = old("a.txt");
    checkWritable(file);
    checkWritable(folder_ / "new.txt");
    OutputFile(folder_ / "new.txt").write("x", 1);
    EXPECT_EQ(readBytes(file), OLD);
    EXPECT_EQ(filesInFolder(), 1u);
}

/// A process of the same number in another container makes the same names up.
TEST_F(Output, AFileThatAnotherProcessIsWritingIsLeftAlone)
{
    const auto prefix = fmt::format(".restirpg-{}-{}-", host(), getpid());
    uint64_t last = 0;
    {
        const OutputFile ours(folder_ / "a.txt");
        const auto name = fs::directory_iterator(folder_)->path().filename().string();
        ASSERT_EQ(name.substr(0, prefix.size()), prefix);
        last = std::stoull(name.substr(prefix.size()));
    }
    const auto theirs = old(fmt::format("{}{}.tmp", prefix, last + 1));
    writeFile(folder_ / "a.txt", "ours");
    EXPECT_EQ(readBytes(theirs), OLD);
    const auto next = old(fmt::format("{}{}.tmp", prefix, last + 3));
    checkWritable(folder_ / "a.txt");
    EXPECT_EQ(readBytes(next), OLD);
    EXPECT_EQ(readBytes(folder_ / "a.txt"), (std::vector<char>{'o', 'u', 'r', 's'}));
    EXPECT_EQ(filesInFolder(), 3u);
}

TEST_F(Output, WhatAKilledProcessLeftIsRemovedADayLater)
{
    const pid_t ended = fork();
    if (ended == 0)
        _exit(0);
    ASSERT_EQ(waitpid(ended, nullptr, 0), ended);
    const auto abandoned = old(fmt::format(".restirpg-{}-{}-7.tmp", host(), ended));
    const std::vector<fs::path> kept = {old(fmt::format(".restirpg-{}-{}-7.tmp", host(), getppid())),
                                        old(fmt::format(".restirpg-another-{}-7.tmp", ended)),
                                        old(fmt::format(".restirpg-{}-{}-7.tmp.exr", host(), ended)),
                                        old(fmt::format(".restirpg-{}-{}.tmp", host(), ended))};
    writeFile(folder_ / "a.txt", "x");
    EXPECT_TRUE(fs::exists(abandoned)) << "another container's process of this number may be writing it";
    for (const auto& file : fs::directory_iterator(folder_))
        fs::last_write_time(file, fs::file_time_type::clock::now() - std::chrono::hours(25));
    writeFile(folder_ / "a.txt", "x");
    EXPECT_FALSE(fs::exists(abandoned));
    for (const auto& file : kept)
        EXPECT_TRUE(fs::exists(file)) << file;
}

TEST_F(Output, PermissionsAndLinksAreKept)
{
    const auto file = old("a.txt");
    chmod(file.c_str(), 0640);
    fs::create_symlink("a.txt", folder_ / "link.txt");
    writeFile(folder_ / "link.txt", "new");
    EXPECT_TRUE(fs::is_symlink(folder_ / "link.txt"));
    EXPECT_EQ(readBytes(file), (std::vector<char>{'n', 'e', 'w'}));
    fs::create_symlink("later.txt", folder_ / "early.txt");
    writeFile(folder_ / "early.txt", "x");
    EXPECT_TRUE(fs::is_regular_file(folder_ / "later.txt"));
    EXPECT_TRUE(fs::is_symlink(folder_ / "early.txt"));
    struct stat status;
    stat(file.c_str(), &status);
    EXPECT_EQ(status.st_mode & 07777u, 0640u);
}

TEST_F(Output, WhatIsNoFileIsRefused)
{
    mkfifo((folder_ / "pipe").c_str(), 0600);
    EXPECT_TRUE(contains(errorOf([&] { writeFile(folder_ / "pipe", "x"); }), "pipe: cannot write: it is a device"));
    EXPECT_TRUE(contains(errorOf([&] { writeFile("/dev/full", "x"); }), "/dev/full: cannot write: it is a device"));
    EXPECT_TRUE(contains(errorOf([&] { writeFile(folder_, "x"); }), "it is a folder; name a file"));
    EXPECT_TRUE(contains(errorOf([&] { writeFile(folder_ / "no/a", "x"); }), "does not exist; create it first"));
    EXPECT_EQ(filesInFolder(), 1u);
}

TEST_F(Output, ANameOfTheLongestLengthIsWritten)
{
    writeFile(folder_ / std::string(255, 'n'), "x");
    EXPECT_EQ(filesInFolder(), 1u);
    EXPECT_TRUE(contains(errorOf([&] { writeFile(folder_ / std::string(256, 'n'), "x"); }), "File name too long"));
}

}  // namespace
}  // namespace restirpg
