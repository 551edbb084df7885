#include "scene/gltf_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <set>

namespace restirpg::gltf {

namespace {

using nlohmann::json;

/// Deeper nesting than any exporter writes; tinygltf recurses over `extras` and `extensions`.
constexpr int MAX_JSON_DEPTH = 64;

constexpr uint32_t GLB_MAGIC = 0x46546c67u;
constexpr uint32_t GLB_JSON = 0x4e4f534au;
constexpr uint32_t GLB_BIN = 0x004e4942u;

/// What the reader reads; everything else is refused when required and named in a warning when not.
const std::set<std::string> SUPPORTED_EXTENSIONS = {
    "KHR_materials_emissive_strength", "KHR_materials_transmission", "KHR_materials_ior",
    "KHR_materials_specular",          "KHR_materials_volume",       "KHR_materials_unlit",
    "KHR_texture_transform",           "KHR_lights_punctual",        "KHR_mesh_quantization",
};

std::vector<uint8_t> readBytes(const std::filesystem::path& path)
{
    std::error_code error;
    if (!std::filesystem::exists(path, error))
        fail("{}: no such file; check the path", path.string());
    if (!std::filesystem::is_regular_file(path, error))
        fail("{}: not a file; name a .gltf or .glb file", path.string());
    const auto size = std::filesystem::file_size(path, error);
    if (error || size > 0xffffffffu)
        fail("{}: larger than 4 GiB, which a glTF file cannot be; split it", path.string());
    std::vector<uint8_t> bytes(size);
    std::ifstream stream(path, std::ios::binary);
    if (!stream.read(reinterpret_cast<char*>(bytes.data()), std::streamsize(size)))
        fail("{}: cannot be read; check its permissions", path.string());
    return bytes;
}

uint32_t word(const std::vector<uint8_t>& bytes, size_t offset)
{
    uint32_t value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

bool isBinary(const std::vector<uint8_t>& bytes)
{
    return bytes.size() >= 4 && word(bytes, 0) == GLB_MAGIC;
}

/// The JSON text of a file, after every length of a GLB container was checked against the file's own.
std::string_view jsonText(const std::string& file, const std::vector<uint8_t>& bytes)
{
    const auto* text = reinterpret_cast<const char*>(bytes.data());
    if (!isBinary(bytes))
        return {text, bytes.size()};
    if (bytes.size() < 20)
        fail("{}: truncated: {} bytes are less than a GLB header; copy the file again", file, bytes.size());
    if (word(bytes, 4) != 2)
        fail("{}: GLB version {}; export it as glTF 2.0", file, word(bytes, 4));
    if (word(bytes, 8) > bytes.size())
        fail("{}: truncated: the header says {} bytes, the file has {}; copy the file again", file, word(bytes, 8),
             bytes.size());
    uint64_t end = 12;
    for (int chunk = 0; chunk < 2 && (chunk == 0 || end + 8 <= word(bytes, 8)); ++chunk) {
        const uint64_t length = word(bytes, end);
        if (end + 8 + length > word(bytes, 8))
            fail("{}: damaged: GLB chunk {} of {} bytes leaves the file; export it again", file, chunk, length);
        if (word(bytes, end + 4) != (chunk == 0 ? GLB_JSON : GLB_BIN))
            fail("{}: damaged: GLB chunk {} is not {}; export it again", file, chunk, chunk == 0 ? "JSON" : "BIN");
        end += 8 + length;
    }
    return {text + 20, word(bytes, 12)};
}

/// Deepest nesting of brackets outside strings. (nlohmann's parser callback would tell, too, but in quadratic time.)
int nestingDepth(std::string_view text)
{
    int depth = 0, deepest = 0;
    bool quoted = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (quoted && c == '\\')
            ++i;
        else if (c == '"')
            quoted = !quoted;
        else if (!quoted && (c == '{' || c == '['))
            deepest = std::max(deepest, ++depth);
        else if (!quoted && (c == '}' || c == ']'))
            --depth;
    }
    return deepest;
}

json parseJson(const std::string& file, std::string_view text)
{
    if (nestingDepth(text) > MAX_JSON_DEPTH)
        fail("{}: JSON nested deeper than {} levels; no exporter writes that, get the file anew", file, MAX_JSON_DEPTH);
    try {
        return json::parse(text);
    } catch (const json::exception& error) {
        fail("{}: not glTF: {}; export it again", file, printable(error.what()));
    }
}

void checkExtensions(const std::string& file, const json& root)
{
    const auto list = [&](const char* name) { return root.value(name, std::vector<std::string>()); };
    for (const auto& required : list("extensionsRequired"))
        if (!SUPPORTED_EXTENSIONS.count(required))
            fail("{}: needs the extension {}, which is not supported; export it without", file, printable(required));
    for (const auto& used : list("extensionsUsed"))
        if (!SUPPORTED_EXTENSIONS.count(used))
            warn("{}: the optional extension {} is ignored", file, printable(used));
}

/// tinygltf's access to external files: only beside the glTF file, and every byte goes into the hash.
struct ExternalFiles {
    std::string folder;
    uint64_t hash;
};

bool externalExists(const std::string& path, void* user)
{
    std::error_code error;
    const auto& folder = static_cast<ExternalFiles*>(user)->folder;
    return path.compare(0, folder.size(), folder) == 0 && std::filesystem::is_regular_file(path, error);
}

bool readExternal(std::vector<unsigned char>* bytes, std::string* error, const std::string& path, void* user)
{
    try {
        *bytes = readBytes(path);
    } catch (const std::exception& exception) {
        *error = exception.what();
        return false;
    }
    auto& hash = static_cast<ExternalFiles*>(user)->hash;
    hash = hashBytes(bytes->data(), bytes->size(), hash);
    return true;
}

/// Keeps the encoded bytes: only textures that a material uses are worth decoding.
bool keepEncoded(tinygltf::Image* image, int, std::string*, std::string*, int, int, const unsigned char* bytes,
                 int size, void*)
{
    if (image->bufferView < 0 && size > 0)
        image->image.assign(bytes, bytes + size);
    return true;
}

}  // namespace

uint64_t hashBytes(const void* bytes, size_t size, uint64_t hash)
{
    const auto* byte = static_cast<const uint8_t*>(bytes);
    for (size_t i = 0; i < size; ++i)
        hash = (hash ^ byte[i]) * 0x100000001b3u;
    return hash;
}

std::string printable(std::string_view text)
{
    constexpr size_t LONGEST = 200;
    std::string line(text.substr(0, LONGEST));
    std::replace_if(line.begin(), line.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, '?');
    return text.size() > LONGEST ? line + "..." : line;
}

std::string label(std::string_view kind, size_t index, const std::string& name)
{
    return name.empty() ? fmt::format("{} {}", kind, index)
                        : fmt::format("{} {} '{}'", kind, index, printable(std::string_view(name).substr(0, 60)));
}

const tinygltf::Value* member(const tinygltf::Value& object, const char* name)
{
    return object.Has(name) ? &object.Get(name) : nullptr;
}

const tinygltf::Value* extension(const tinygltf::ExtensionMap& map, const char* name)
{
    const auto found = map.find(name);
    return found == map.end() ? nullptr : &found->second;
}

float number(const tinygltf::Value& object, const char* name, double otherwise)
{
    const auto* value = member(object, name);
    return float(value && value->IsNumber() ? value->GetNumberAsDouble() : otherwise);
}

glm::vec3 color(const tinygltf::Value& object, const char* name, glm::vec3 otherwise)
{
    const auto* value = member(object, name);
    if (!value || value->ArrayLen() != 3)
        return otherwise;
    const auto component = [&](int i) { return float(value->Get(i).GetNumberAsDouble()); };
    return {component(0), component(1), component(2)};
}

File readFile(const std::filesystem::path& path)
{
    File file;
    file.path = path;
    const auto bytes = readBytes(path);
    const auto text = jsonText(file.name(), bytes);
    {
        const auto root = parseJson(file.name(), text);
        checkStructure(file.name(), root);
        checkExtensions(file.name(), root);
    }

    // An absolute folder keeps tinygltf from falling back to the working directory.
    ExternalFiles external{std::filesystem::absolute(path).parent_path().string(),
                           hashBytes(bytes.data(), bytes.size())};
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader(keepEncoded, nullptr);
    reader.SetFsCallbacks(
        {externalExists, [](const std::string& name, void*) { return name; }, readExternal, nullptr, &external});
    std::string error, warning;
    bool read = false;
    if (isBinary(bytes))
        read = reader.LoadBinaryFromMemory(&file.model, &error, &warning, bytes.data(), unsigned(bytes.size()),
                                           external.folder);
    else
        read = reader.LoadASCIIFromString(&file.model, &error, &warning, text.data(), unsigned(text.size()),
                                          external.folder);
    if (!read)
        fail("{}: damaged: {}; export it again", file.name(), printable(error));
    file.hash = external.hash;
    return file;
}

}  // namespace restirpg::gltf
