#include "core/cache_file.h"

#include "core/hash.h"
#include "core/log.h"
#include "core/output_file.h"

#include <cstring>
#include <fstream>
#include <mutex>

namespace restirpg {
namespace {

struct Header {
    char magic[8] = {'r', 'e', 's', 't', 'i', 'r', 'p', 'g'};
    uint64_t bytes = 0;
    uint64_t checksum = 0;
};

Header headerOf(std::span<const std::byte> contents)
{
    Header header;
    header.bytes = contents.size();
    header.checksum = hashBytes(contents.data(), contents.size());
    return header;
}

}  // namespace

std::optional<std::vector<std::byte>> readCacheFile(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    Header header;
    if (!stream.read(reinterpret_cast<char*>(&header), sizeof header))
        return {};
    std::error_code error;
    const auto size = std::filesystem::file_size(file, error);
    if (error || std::memcmp(header.magic, Header().magic, sizeof header.magic) != 0 ||
        size - sizeof header != header.bytes)
        return {};
    std::vector<std::byte> contents(header.bytes);
    if (!stream.read(reinterpret_cast<char*>(contents.data()), std::streamsize(contents.size())))
        return {};
    return headerOf(contents).checksum == header.checksum ? std::optional(std::move(contents)) : std::nullopt;
}

void writeCacheFile(const std::filesystem::path& file, std::span<const std::byte> contents)
{
    try {
        std::filesystem::create_directories(file.parent_path());
        OutputFile output(file);
        const Header header = headerOf(contents);
        output.write(&header, sizeof header);
        output.write(contents.data(), contents.size());
        output.commit();
    } catch (const std::exception& error) {
        static std::once_flag said;
        std::call_once(said, [&] {
            warn(
                "{}; kernels are compiled again at every start (RESTIRPG_CACHE_DIR names another folder for the cache)",
                error.what());
        });
    }
}

}  // namespace restirpg
