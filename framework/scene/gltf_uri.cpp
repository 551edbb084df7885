// What a glTF file's URIs stand for: data URIs, and files at or below its folder.
#include "scene/gltf_file.h"

#include "core/error_kinds.h"
#include "core/memory.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fstream>

namespace restirpg::gltf {

namespace {

namespace fs = std::filesystem;

bool startsWith(std::string_view text, std::string_view lowerCase)
{
    return text.size() >= lowerCase.size() &&
           std::equal(lowerCase.begin(), lowerCase.end(), text.begin(),
                      [](char expected, char c) { return std::tolower(uint8_t(c)) == expected; });
}

/// RFC 3986, 2.1; a '%' that no two hexadecimal digits follow stands for itself.
std::string percentDecoded(std::string_view text)
{
    std::string result;
    for (size_t i = 0; i < text.size(); ++i) {
        uint8_t byte = 0;
        const char* const digits = text.data() + i + 1;
        if (text[i] == '%' && i + 2 < text.size() && std::isxdigit(uint8_t(*digits)) &&
            std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
            result += char(byte);
            i += 2;
        } else {
            result += text[i];
        }
    }
    return result;
}

/// The part of a URI that names a file here, still percent-encoded; fails for other machines and other schemes.
std::string_view localPart(std::string_view uri, const std::string& file, const std::string& place)
{
    if (startsWith(uri, "file:")) {
        uri.remove_prefix(5);
        if (startsWith(uri, "//localhost/"))
            uri.remove_prefix(11);
        else if (startsWith(uri, "///"))
            uri.remove_prefix(2);
    }
    const auto scheme = uri.find("://");
    const bool named = scheme != uri.npos && std::all_of(uri.begin(), uri.begin() + long(scheme), [](char c) {
                           return std::isalnum(uint8_t(c)) || c == '+' || c == '-' || c == '.';
                       });
    if (named || startsWith(uri, "//"))
        fail("{}: {}: '{}' lies on another machine; put the file beside the scene", file, place, printable(uri));
    return uri;
}

bool isWithin(const fs::path& folder, const fs::path& path)
{
    return std::mismatch(folder.begin(), folder.end(), path.begin(), path.end()).first == folder.end();
}

}  // namespace

Resources::Resources(const fs::path& scene, bool allowOutside)
    : scene_(scene), folder_(fs::weakly_canonical(fs::absolute(scene).parent_path())), allowOutside_(allowOutside)
{
}

bool Resources::isData(const std::string& uri)
{
    return startsWith(uri, "data:");
}

std::vector<uint8_t> Resources::readData(const std::string& uri, const std::string& place) const
{
    const auto comma = uri.find(',');
    if (comma == uri.npos)
        fail("{}: {}: the data URI has no comma; export it again", scene_.string(), place);
    const std::string_view header = std::string_view(uri).substr(0, comma), base64 = ";base64";
    auto text = percentDecoded(std::string_view(uri).substr(comma + 1));
    if (header.size() < base64.size() || !startsWith(header.substr(header.size() - base64.size()), base64))
        return {text.begin(), text.end()};
    std::erase_if(text, [](unsigned char c) { return std::isspace(c); });
    // tinygltf decodes a few media types only. The type is of no use to us: an image's own first bytes say what it is.
    std::vector<uint8_t> bytes;
    std::string type;
    if (!tinygltf::DecodeDataURI(&bytes, type, "data:application/octet-stream;base64," + text, 0, false))
        fail("{}: {}: the data URI is not base64; export it again", scene_.string(), place);
    return bytes;
}

fs::path Resources::resolve(std::string_view name, const std::string& place) const
{
    std::error_code error;
    auto path = fs::weakly_canonical(folder_ / fs::path(name), error);
    if (error || name.empty() || name.find('\0') != name.npos)
        fail("{}: {}: '{}' names no file; put the file beside the scene", scene_.string(), place, printable(name));
    if (!allowOutside_ && !isWithin(folder_, path))
        fail("{}: {}: '{}' lies outside of the scene's folder; put the file there, or allow it (--allow-outside, "
             "allow_outside=True)",
             scene_.string(), place, printable(name));
    if (fs::exists(path, error) && !fs::is_regular_file(path, error))
        fail("{}: {}: '{}' is not a regular file; put one in its place", scene_.string(), place, printable(name));
    return path;
}

fs::path Resources::resolveUri(const std::string& uri, const std::string& place) const
{
    auto name = percentDecoded(localPart(uri, scene_.string(), place));
    auto path = resolve(name, place);
    std::error_code error;
    if (!fs::exists(path, error) && name.find('\\') != name.npos) {  // written by an exporter on Windows
        std::replace(name.begin(), name.end(), '\\', '/');
        path = resolve(name, place);
    }
    return path;
}

fs::path Resources::resolveExisting(const std::string& uri, const std::string& place) const
{
    auto path = resolveUri(uri, place);
    std::error_code error;
    if (!fs::exists(path, error))
        failAs<MissingFile>("{}: {}: '{}': no such file; put it beside the scene", scene_.string(), place,
                            printable(uri));
    return path;
}

std::vector<uint8_t> readBytes(const fs::path& path)
{
    std::error_code error;
    if (!fs::exists(path, error))
        failAs<MissingFile>("{}: no such file; check the path", path.string());
    if (!fs::is_regular_file(path, error))
        fail("{}: not a file; name one", path.string());
    const auto size = fs::file_size(path, error);
    if (error || size > 0xffffffffu)
        fail("{}: larger than 4 GiB; give a smaller file", path.string());
    checkMemory(path.string(), "reading it", size, "give a smaller file");
    std::vector<uint8_t> bytes(size);
    std::ifstream stream(path, std::ios::binary);
    if (!stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size)))
        fail("{}: cannot be read; check its permissions", path.string());
    return bytes;
}

}  // namespace restirpg::gltf
