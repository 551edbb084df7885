// Kernels: compiled side by side, shared by the devices of a process, kept in a cache that may be damaged.
#include "gpu_test.h"

#include "core/cache_file.h"
#include "core/error_kinds.h"

#include <atomic>
#include <chrono>
#include <climits>
#include <filesystem>
#include <fstream>
#include <numeric>
#include <span>
#include <thread>

#include <fcntl.h>
#include <sys/inotify.h>
#include <sys/stat.h>
#include <unistd.h>

namespace restirpg::test {
namespace {

namespace fs = std::filesystem;

/// A folder of a test's own, with the cache in it.
struct Folder {
    fs::path path = fs::temp_directory_path() / fmt::format("restirpg_kernel_test_{}", getpid());

    Folder()
    {
        fs::remove_all(path);
        fs::create_directories(path);
        setenv("RESTIRPG_CACHE_DIR", (path / "cache").c_str(), 1);
    }
    ~Folder()
    {
        unsetenv("RESTIRPG_CACHE_DIR");
        fs::remove_all(path);
    }
    fs::path write(const std::string& name, const std::string& text) const
    {
        std::ofstream(path / name) << text;
        return path / name;
    }
    std::vector<fs::path> cached(const std::string& kind = "spirv") const
    {
        std::vector<fs::path> files;
        if (fs::exists(path / "cache" / kind))
            for (const auto& entry : fs::directory_iterator(path / "cache" / kind))
                files.push_back(entry.path());
        return files;
    }
};

std::string kernelOfSize(const std::string& size)
{
    return "layout(local_size_x = " + size + ") in;\nvoid main() {}\n";
}

std::vector<std::byte> bytesOf(const std::string& text)
{
    const auto bytes = std::as_bytes(std::span(text));
    return {bytes.begin(), bytes.end()};
}

TEST(Kernel, OneOfEachSpirvInAProcess)
{
    const Folder folder;
    const auto file = folder.write("a.comp", kernelOfSize("8"));
    const auto same = folder.write("b.comp", "// other text\n" + kernelOfSize("8"));
    const auto other = folder.write("c.comp", kernelOfSize("16"));
    const DeviceOptions options{.device = testDevice(), .validation = true};
    const Pipeline* const pipeline = [&] {
        Device first(options);
        const Kernel kernel(first, file);
        first.finishKernels();
        return &kernel.pipeline();
    }();
    Device second(options);
    EXPECT_EQ(&Kernel(second, file).pipeline(), pipeline);
    EXPECT_EQ(&Kernel(second, same).pipeline(), pipeline);
    EXPECT_NE(&Kernel(second, other).pipeline(), pipeline);
    EXPECT_EQ(Kernel(second, other).pipeline().groupSize().x, 16u);
}

TEST(LogicalDevice, ThatIsLostIsReplaced)
{
    const DeviceOptions options{.device = testDevice(), .validation = true};
    const auto lost = LogicalDevice::get(options);
    EXPECT_EQ(LogicalDevice::get(options), lost);
    const auto messageOf = [&](VkResult result) {
        try {
            lost->checkWork(result, "vkQueueSubmit");
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_EQ(messageOf(VK_SUCCESS), "");
    EXPECT_NE(messageOf(VK_ERROR_OUT_OF_HOST_MEMORY), "");
    EXPECT_EQ(LogicalDevice::get(options), lost) << "it still works";
    EXPECT_EQ(messageOf(VK_ERROR_DEVICE_LOST),
              "the device is lost (vkQueueSubmit): its driver failed, or ended work that took too long; make another "
              "renderer, of a smaller size or window");
    const auto other = LogicalDevice::get(options);
    EXPECT_NE(other, lost);
    EXPECT_EQ(LogicalDevice::get(options), other);
    Device device(options);
    EXPECT_EQ(&device.logical(), other.get());
    device.submit([](VkCommandBuffer) {});
}

TEST(LogicalDevice, DigitsAreANumberAndOtherTextIsAPartOfAName)
{
    std::vector<DeviceDescription> devices(3);
    devices[0].name = "Radeon RX 6800 (RADV NAVI21)";
    devices[1].name = "GeForce RTX 3090";
    devices[2].name = "llvmpipe (128 bits)";
    EXPECT_EQ(chooseDevice(devices, "1"), 1u);
    EXPECT_EQ(chooseDevice(devices, "2"), 2u);
    EXPECT_EQ(chooseDevice(devices, "RTX 3090"), 1u);
    EXPECT_EQ(chooseDevice(devices, "llvmpipe"), 2u);
    for (const char* none : {"3", "6800", "99999999999999999999999", "Voodoo"})
        EXPECT_THROW(chooseDevice(devices, none), WrongValue) << none;
}

TEST(LogicalDevice, TimeStampsStartOver)
{
    EXPECT_EQ(ticksBetween(5, 12, 64), 7u);
    EXPECT_EQ(ticksBetween(UINT64_MAX, 1, 64), 2u);
    EXPECT_EQ(ticksBetween(0xfffffff0, 0x10, 32), 0x20u);
    EXPECT_EQ(ticksBetween(0xfffffffff, 0, 36), 1u);
    EXPECT_GT(device().logical().milliseconds(0, 1000), 0);
}

/// A logical device of its own without validation, which is on for the other tests.
std::shared_ptr<LogicalDevice> unvalidatedDevice()
{
    const char* set = std::getenv("RESTIRPG_VALIDATION");
    const std::string before = set ? set : "";
    unsetenv("RESTIRPG_VALIDATION");
    auto device = std::make_shared<LogicalDevice>(DeviceOptions{.device = testDevice()});
    if (set)
        setenv("RESTIRPG_VALIDATION", before.c_str(), 1);
    return device;
}

/// What a kernel writes that numbers its invocations from 7.
std::vector<uint32_t> numbersOf(const std::shared_ptr<LogicalDevice>& logical, const fs::path& file)
{
    std::vector<uint32_t> numbers(16);
    Device device(logical);
    const Buffer results = device.createBuffer(numbers.size() * sizeof(uint32_t), "numbers");
    const Kernel kernel(device, file);
    const VkDeviceAddress address = results.address();
    device.submit([&](VkCommandBuffer commands) {
        kernel.dispatch(commands, &address, sizeof(address), uint32_t(numbers.size()));
    });
    device.download(results, numbers.data(), numbers.size() * sizeof(uint32_t));
    return numbers;
}

TEST(Kernel, AShaderObjectIsKeptAndMadeAnewWhereItsBinaryIsNotTheDrivers)
{
    const Folder folder;
    const auto file =
        folder.write("numbers.comp", "#extension GL_EXT_buffer_reference : require\n"
                                     "layout(local_size_x = 8) in;\n"
                                     "layout(buffer_reference, std430) buffer Numbers { uint at[]; };\n"
                                     "layout(push_constant) uniform Push { Numbers numbers; };\n"
                                     "void main() { uint i = gl_GlobalInvocationID.x; numbers.at[i] = 7u + i; }\n");
    std::vector<uint32_t> expected(16);
    std::iota(expected.begin(), expected.end(), 7u);
    if (!unvalidatedDevice()->shaderObjects())
        GTEST_SKIP() << "NOT TESTED: this device has no shader objects (VK_EXT_shader_object), or makes no use of them";

    EXPECT_EQ(numbersOf(unvalidatedDevice(), file), expected);
    ASSERT_EQ(folder.cached("binary").size(), 1u);
    const fs::path binary = folder.cached("binary").front();
    const auto kept = readCacheFile(binary);
    ASSERT_TRUE(kept);
    const auto written = fs::last_write_time(binary);
    EXPECT_EQ(numbersOf(unvalidatedDevice(), file), expected);
    EXPECT_EQ(fs::last_write_time(binary), written) << "was not taken from there";

    for (const auto& other : {bytesOf("no binary of any driver"), std::vector(kept->begin() + 1, kept->end())}) {
        writeCacheFile(binary, other);
        EXPECT_EQ(numbersOf(unvalidatedDevice(), file), expected);
        EXPECT_EQ(readCacheFile(binary), kept) << "was not written anew";
    }
    EXPECT_EQ(numbersOf(LogicalDevice::get({.device = testDevice(), .validation = true}), file), expected);
    EXPECT_EQ(folder.cached("binary").size(), 1u) << "validation layers get a pipeline";
}

TEST(Kernel, TheFirstMistakeIsThrownWithItsPlaceByFinishKernels)
{
    const Folder folder;
    const auto good = folder.write("good.comp", kernelOfSize("8"));
    const auto bad = folder.write("bad.comp", "layout(local_size_x = 8) in;\nvoid main() { nothing(); }\n");
    Device device(DeviceOptions{.device = testDevice(), .validation = true});
    const Kernel first(device, good), second(device, bad), third(device, bad), fourth(device, good);
    std::vector<uint32_t> told;
    try {
        device.finishKernels([&](uint32_t done, uint32_t total) {
            told.push_back(done);
            EXPECT_EQ(total, 4u);
        });
        ADD_FAILURE() << "nothing was thrown";
    } catch (const Error& error) {
        EXPECT_EQ(std::string(error.what()),
                  fs::canonical(bad).string() + ":2: 'nothing' : no matching overloaded function found");
    }
    EXPECT_EQ(told, (std::vector<uint32_t>{0, 1}));
    EXPECT_EQ(fourth.pipeline().groupSize().x, 8u);
    device.finishKernels();  // what failed is not said again
}

TEST(Kernel, AMistakeIsOneLine)
{
    const Folder folder;
    const auto messageOf = [&](const std::string& body) {
        const auto file = folder.write("bad.comp", "layout(local_size_x = 8) in;\n" + body);
        try {
            compileShader(file);
        } catch (const Error& error) {
            std::string text = error.what();
            for (size_t at; (at = text.find(fs::canonical(file).string())) != std::string::npos;)
                text.replace(at, fs::canonical(file).string().size(), "FILE");
            return text;
        }
        return std::string();
    };
    EXPECT_EQ(messageOf("void main() {\n    nothing();\n    a = 1;\n}\n"),
              "FILE:3: 'nothing' : no matching overloaded function found");
    EXPECT_EQ(messageOf("#include \"none.glsl\"\nvoid main() {}\n"),
              "FILE:2: '#include' : Could not process include directive for header name: none.glsl");
    EXPECT_EQ(messageOf("void other();\nvoid main() { other(); }\n"),
              "FILE: Linking compute stage: No function definition (body) found: other(");
}

TEST(Kernel, AnEditOfAnIncludedFileIsSeen)
{
    const Folder folder;
    folder.write("size.glsl", "#define SIZE 8\n");
    folder.write("middle.glsl", "#  include \"size.glsl\"\n");
    const auto file = folder.write("a.comp", "#include \"middle.glsl\"\n" + kernelOfSize("SIZE"));
    EXPECT_EQ(localSize(compileShader(file)).x, 8u);
    EXPECT_EQ(localSize(compileShader(file)).x, 8u);
    EXPECT_EQ(folder.cached().size(), 1u);
    folder.write("size.glsl", "#define SIZE 16\n");
    EXPECT_EQ(localSize(compileShader(file)).x, 16u);
    EXPECT_EQ(localSize(compileShader(file, {{"UNUSED", "1"}})).x, 16u);
    EXPECT_EQ(folder.cached().size(), 3u);
    folder.write("other.glsl", "#define SIZE 32\n");
    EXPECT_EQ(localSize(compileShader(file, {}, {{"size.glsl", folder.path / "other.glsl"}})).x, 32u);
}

/// Serves a kernel's text to each who opens the pipe. Between the reader that hashes it and the one that translates it,
/// the file that it includes is edited.
class EditedUnderWay {
public:
    EditedUnderWay(const fs::path& pipe, const std::string& text, const fs::path& included, const std::string& edited)
        : thread_([=, this] {
              const int watch = inotify_init1(IN_CLOEXEC | IN_NONBLOCK);
              inotify_add_watch(watch, included.c_str(), IN_CLOSE_NOWRITE);
              for (int served = 0; serve(pipe, text); ++served) {
                  alignas(inotify_event) char event[sizeof(inotify_event) + NAME_MAX + 1];
                  while (read(watch, event, sizeof event) <= 0 && !ended_)  // until this reader is through with both
                      std::this_thread::sleep_for(std::chrono::milliseconds(1));
                  if (served == 0)
                      std::ofstream(included) << edited;
              }
              close(watch);
          })
    {
    }
    ~EditedUnderWay()
    {
        ended_ = true;
        thread_.join();
    }

private:
    /// False: nobody opens the pipe any more.
    bool serve(const fs::path& pipe, const std::string& text) const
    {
        int descriptor;
        while ((descriptor = open(pipe.c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC)) < 0) {
            if (ended_)
                return false;
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        }
        const bool written = write(descriptor, text.data(), text.size()) == ssize_t(text.size());
        close(descriptor);
        return written;
    }

    std::atomic<bool> ended_ = false;
    std::thread thread_;
};

TEST(Kernel, ThatIsEditedWhileItIsCompiledIsNotKept)
{
    const Folder folder;
    const auto included = folder.write("size.glsl", "#define SIZE 8\n");
    const fs::path pipe = folder.path / "a.comp";
    ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
    const EditedUnderWay edited(pipe, "#include \"size.glsl\"\n" + kernelOfSize("SIZE"), included, "#define SIZE 16\n");
    EXPECT_EQ(localSize(compileShader(pipe)).x, 16u);
    EXPECT_TRUE(folder.cached().empty()) << "under the name of the text before the edit";
    EXPECT_EQ(localSize(compileShader(pipe)).x, 16u);
    EXPECT_EQ(folder.cached().size(), 1u);
}

TEST(Kernel, DamagedCacheFilesAreMadeAnew)
{
    const Folder folder;
    const auto file = folder.write("a.comp", kernelOfSize("8"));
    const Spirv spirv = compileShader(file);
    ASSERT_EQ(folder.cached().size(), 1u);
    const fs::path cached = folder.cached().front();
    const auto intact = readCacheFile(cached);
    ASSERT_TRUE(intact);
    const auto size = fs::file_size(cached);
    for (const uintmax_t left : {uintmax_t(0), uintmax_t(5), uintmax_t(24), size - 4, size - 1}) {
        fs::resize_file(cached, left);
        EXPECT_FALSE(readCacheFile(cached)) << left;
        EXPECT_EQ(compileShader(file), spirv);
        EXPECT_EQ(readCacheFile(cached), intact) << "was not written anew";
    }
}

TEST(CacheFile, EveryFlippedBitIsFound)
{
    const Folder folder;
    const fs::path file = folder.path / "cache/kind/name";
    const auto contents = bytesOf("some contents");
    writeCacheFile(file, contents);
    ASSERT_EQ(readCacheFile(file), contents);
    const auto size = fs::file_size(file);
    for (uintmax_t bit = 0; bit < 8 * size; ++bit) {
        const auto flip = [&] {
            std::fstream stream(file, std::ios::in | std::ios::out | std::ios::binary);
            stream.seekg(std::streamoff(bit / 8));
            const char flipped = char(stream.get() ^ (1 << bit % 8));
            stream.seekp(std::streamoff(bit / 8));
            stream.put(flipped);
        };
        flip();
        EXPECT_FALSE(readCacheFile(file)) << bit;
        flip();
    }
    EXPECT_EQ(readCacheFile(file), contents);
}

TEST(CacheFile, AFolderThatCannotBeHadStopsNothing)
{
    const Folder folder;
    folder.write("cache", "a file where the folder should be");
    const auto file = folder.write("a.comp", kernelOfSize("8"));
    EXPECT_EQ(localSize(compileShader(file)).x, 8u);
    EXPECT_FALSE(readCacheFile(folder.path / "cache/spirv/name"));
}

}  // namespace
}  // namespace restirpg::test
