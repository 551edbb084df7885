#include "scene/gltf_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <map>
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

uint32_t word(std::span<const uint8_t> bytes, size_t offset)
{
    uint32_t value;
    std::memcpy(&value, bytes.data() + offset, sizeof value);
    return value;
}

bool isBinary(std::span<const uint8_t> bytes)
{
    return bytes.size() >= 4 && word(bytes, 0) == GLB_MAGIC;
}

/// The parts of a file; `binary` is empty for .gltf.
struct Container {
    std::string_view json;
    std::span<const uint8_t> binary;
};

/// The chunk of a GLB container at `offset`, after its length was checked against the file's own.
std::span<const uint8_t> chunkAt(const std::string& file, std::span<const uint8_t> bytes, size_t offset,
                                 const char* name)
{
    const uint64_t length = word(bytes, offset);
    if (offset + 8 + length > bytes.size())
        fail("{}: damaged: the GLB's {} chunk of {} bytes leaves the file; export it again", file, name, length);
    return bytes.subspan(offset + 8, length);
}

/// The binary chunk is the second, or there is none. Chunks of other types belong to extensions and are skipped [glTF
/// 2.0, 4.4.2].
Container openContainer(const std::string& file, std::span<const uint8_t> bytes)
{
    const auto text = [](std::span<const uint8_t> chunk) {
        return std::string_view(reinterpret_cast<const char*>(chunk.data()), chunk.size());
    };
    if (!isBinary(bytes))
        return {text(bytes), {}};
    if (bytes.size() < 20)
        fail("{}: truncated: {} bytes are less than a GLB header; copy the file again", file, bytes.size());
    if (word(bytes, 4) != 2)
        fail("{}: GLB version {}; export it as glTF 2.0", file, word(bytes, 4));
    if (word(bytes, 8) > bytes.size())
        fail("{}: truncated: the header says {} bytes, the file has {}; copy the file again", file, word(bytes, 8),
             bytes.size());
    bytes = bytes.first(std::max(word(bytes, 8), 20u));
    const auto json = chunkAt(file, bytes, 12, "first");
    if (word(bytes, 16) != GLB_JSON)
        fail("{}: damaged: the GLB's first chunk is not JSON; export it again", file);
    const size_t end = 20 + json.size();
    if (end + 8 > bytes.size())
        return {text(json), {}};
    const auto second = chunkAt(file, bytes, end, "second");
    return {text(json), word(bytes, end + 4) == GLB_BIN ? second : std::span<const uint8_t>()};
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
        auto root = json::parse(text);
        unifyNumbers(root);
        return root;
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

/// The array of that name in an object, which is made where it is missing.
json& arrayIn(json& object, const char* name)
{
    return *object.emplace(name, json::array()).first;
}

/// Bytes of the URIs of a file, by the names that tinygltf is given in their place. It sees no path of the file's.
using Contents = std::map<std::string, std::vector<uint8_t>>;

/// A buffer's bytes: byteLength of them, where the file may have more [glTF 2.0, 3.6.1].
std::vector<uint8_t> bufferBytes(File& file, size_t index, const json& buffer, std::span<const uint8_t> binary,
                                 uint64_t& hash)
{
    const auto place = fmt::format("buffers[{}]", index);
    const auto length = buffer.at("byteLength").get<size_t>();
    const auto uri = buffer.value("uri", std::string());
    std::vector<uint8_t> bytes;
    if (!buffer.contains("uri")) {
        if (index > 0 || binary.empty())
            fail("{}: {}: has no uri, and the file no binary chunk for it; export it again", file.name(), place);
        bytes.assign(binary.begin(), binary.begin() + long(std::min(length, binary.size())));
    } else if (Resources::isData(uri)) {
        bytes = file.resources.readData(uri, place);
    } else {
        file.external.push_back(file.resources.resolveExisting(uri, place));
        bytes = readBytes(file.external.back());
        hash = hashBytes(bytes.data(), bytes.size(), hash);
    }
    if (bytes.size() < length)
        fail("{}: {}: has {} bytes, but byteLength is {}; export it again", file.name(), place, bytes.size(), length);
    bytes.resize(length);
    return bytes;
}

/// The bytes of an image's file, none where it is missing: decodeImage minds, should a material show it.
std::vector<uint8_t> imageBytes(File& file, const std::string& uri, const std::string& place, uint64_t& hash)
{
    const auto path = file.resources.resolveUri(uri, place);
    std::vector<uint8_t> bytes;
    if (std::filesystem::exists(path)) {
        bytes = readBytes(path);
        file.external.push_back(path);
    }
    hash = hashBytes(bytes.data(), bytes.size(), hash);
    return bytes;
}

/// Read what the file refers to, and put names of our own in the place of its URIs.
Contents readContents(File& file, json& root, std::span<const uint8_t> binary, uint64_t& hash)
{
    Contents contents;
    const auto put = [&](json& object, std::string name, std::vector<uint8_t> bytes) {
        contents[name] = std::move(bytes);
        object["uri"] = std::move(name);
    };
    auto& buffers = arrayIn(root, "buffers");
    for (size_t i = 0; i < buffers.size(); ++i)
        put(buffers[i], fmt::format("buffer{}", i), bufferBytes(file, i, buffers[i], binary, hash));
    auto& images = arrayIn(root, "images");
    for (size_t i = 0; i < images.size(); ++i) {
        auto& image = images[i];
        if (!image.contains("uri"))
            continue;
        const auto place = fmt::format("images[{}]", i), name = fmt::format("image{}", i);
        const auto uri = image["uri"].get<std::string>();
        put(image, name,
            Resources::isData(uri) ? file.resources.readData(uri, place) : imageBytes(file, uri, place, hash));
    }
    return contents;
}

/// Takes the primitives' indices out of the JSON: tinygltf refuses those without a buffer view, which are zeros but for
/// their sparse part.
std::vector<int> takeIndices(json& root)
{
    std::vector<int> indices;
    for (auto& mesh : arrayIn(root, "meshes"))
        for (auto& primitive : arrayIn(mesh, "primitives")) {
            indices.push_back(primitive.value("indices", -1));
            primitive.erase("indices");
        }
    return indices;
}

/// Puts them into the model.
void giveIndices(const std::vector<int>& indices, tinygltf::Model& model)
{
    auto next = indices.begin();
    for (auto& mesh : model.meshes)
        for (auto& primitive : mesh.primitives)
            primitive.indices = *next++;
}

bool isContent(const std::string& name, void* contents)
{
    const auto& known = *static_cast<Contents*>(contents);
    const auto found = known.find(name);
    return found != known.end() && !found->second.empty();
}

bool takeContent(std::vector<unsigned char>* bytes, std::string*, const std::string& name, void* contents)
{
    *bytes = std::move(static_cast<Contents*>(contents)->at(name));
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

std::string label(std::string_view kind, size_t index, const std::string& name)
{
    return name.empty() ? fmt::format("{} {}", kind, index)
                        : fmt::format("{} {} '{}'", kind, index, printable(name, 60));
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

File readFile(const std::filesystem::path& path, bool allowOutside)
{
    File file{path, Resources(path, allowOutside)};
    const auto bytes = readBytes(path);
    const auto container = openContainer(file.name(), bytes);
    auto root = parseJson(file.name(), container.json);
    checkStructure(file.name(), root);
    checkExtensions(file.name(), root);

    file.hash = hashBytes(bytes.data(), bytes.size());
    std::vector<std::string> imageNames;
    for (const auto& image : root.value("images", json::array()))
        imageNames.push_back(image.value("uri", std::string()));
    auto contents = readContents(file, root, container.binary, file.hash);
    const auto indices = takeIndices(root);
    tinygltf::TinyGLTF reader;
    reader.SetImageLoader(keepEncoded, nullptr);
    reader.SetFsCallbacks(
        {isContent, [](const std::string& name, void*) { return name; }, takeContent, nullptr, &contents});
    std::string error, warning;
    const auto text = root.dump();
    if (!reader.LoadASCIIFromString(&file.model, &error, &warning, text.data(), unsigned(text.size()), ""))
        fail("{}: damaged: {}; export it again", file.name(), printable(error.substr(0, error.find('\n'))));
    giveIndices(indices, file.model);
    for (size_t i = 0; i < file.model.images.size(); ++i)
        file.model.images[i].uri = Resources::isData(imageNames[i]) ? "" : imageNames[i];
    return file;
}

}  // namespace restirpg::gltf
