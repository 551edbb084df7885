// The structural check: a table of what the glTF 2.0 schema says about each member that the reader uses.
#include "scene/gltf_file.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <charconv>
#include <cmath>

namespace restirpg::gltf {

namespace {

using nlohmann::json;

enum class Kind {
    object,
    text,
    truth,
    size,  ///< counts, and what else tinygltf takes for an int
    bytes,
    number,
    distance,  ///< a number that may stand for infinity
    vector,
    index
};

/// One member: `path` from the root, where `name[]` goes over an array and `*` over all members of an object.
struct Rule {
    std::string path;
    Kind kind;
    bool required = false;  ///< where its parent is there
    size_t length = 0;  ///< vector: how many numbers
    std::string target = {};  ///< index: path of the array that it points into
};

/// Integers beyond this do not fit tinygltf's int; it counts bytes, which end with the largest file, by a size_t.
constexpr double LARGEST_INTEGER = 2147483647.0;
constexpr double LARGEST_FILE = 4294967295.0;
/// Numbers beyond float's range do not fit ours.
constexpr double LARGEST_NUMBER = 1e30;

/// The members of a textureInfo at `path`, KHR_texture_transform included.
void addTextureInfo(std::vector<Rule>& rules, const std::string& path)
{
    const auto transform = path + ".extensions.KHR_texture_transform.";
    rules.insert(rules.end(), {
                                  {path + ".index", Kind::index, true, 0, "textures"},
                                  {path + ".texCoord", Kind::size},
                                  {transform + "offset", Kind::vector, false, 2},
                                  {transform + "scale", Kind::vector, false, 2},
                                  {transform + "rotation", Kind::number},
                                  {transform + "texCoord", Kind::size},
                              });
}

void addMaterials(std::vector<Rule>& rules)
{
    const std::string material = "materials[].", extension = material + "extensions.KHR_materials_";
    rules.insert(rules.end(), {
                                  {material + "name", Kind::text},
                                  {material + "pbrMetallicRoughness.baseColorFactor", Kind::vector, false, 4},
                                  {material + "pbrMetallicRoughness.metallicFactor", Kind::number},
                                  {material + "pbrMetallicRoughness.roughnessFactor", Kind::number},
                                  {material + "normalTexture.scale", Kind::number},
                                  {material + "emissiveFactor", Kind::vector, false, 3},
                                  {material + "alphaMode", Kind::text},
                                  {material + "alphaCutoff", Kind::number},
                                  {material + "doubleSided", Kind::truth},
                                  {extension + "emissive_strength.emissiveStrength", Kind::number},
                                  {extension + "transmission.transmissionFactor", Kind::number},
                                  {extension + "ior.ior", Kind::number},
                                  {extension + "specular.specularFactor", Kind::number},
                                  {extension + "specular.specularColorFactor", Kind::vector, false, 3},
                                  {extension + "volume.thicknessFactor", Kind::number},
                                  {extension + "volume.attenuationDistance", Kind::distance},
                                  {extension + "volume.attenuationColor", Kind::vector, false, 3},
                              });
    for (const char* slot : {"pbrMetallicRoughness.baseColorTexture", "pbrMetallicRoughness.metallicRoughnessTexture",
                             "normalTexture", "emissiveTexture"})
        addTextureInfo(rules, material + slot);
    for (const char* slot :
         {"transmission.transmissionTexture", "specular.specularTexture", "specular.specularColorTexture"})
        addTextureInfo(rules, extension + slot);
}

void addScene(std::vector<Rule>& rules)
{
    const std::string lights = "extensions.KHR_lights_punctual.lights";
    rules.insert(rules.end(), {
                                  {"scene", Kind::index, false, 0, "scenes"},
                                  {"scenes[].nodes[]", Kind::index, false, 0, "nodes"},
                                  {"nodes[].name", Kind::text},
                                  {"nodes[].mesh", Kind::index, false, 0, "meshes"},
                                  {"nodes[].skin", Kind::index, false, 0, "skins"},
                                  {"nodes[].weights[]", Kind::number},
                                  {"meshes[].weights[]", Kind::number},
                                  {"skins[].joints[]", Kind::index, false, 0, "nodes"},
                                  {"skins[].inverseBindMatrices", Kind::index, false, 0, "accessors"},
                                  {"skins[].name", Kind::text},
                                  {"nodes[].camera", Kind::index, false, 0, "cameras"},
                                  {"nodes[].children[]", Kind::index, false, 0, "nodes"},
                                  {"nodes[].translation", Kind::vector, false, 3},
                                  {"nodes[].rotation", Kind::vector, false, 4},
                                  {"nodes[].scale", Kind::vector, false, 3},
                                  {"nodes[].matrix", Kind::vector, false, 16},
                                  {"nodes[].extensions.KHR_lights_punctual.light", Kind::index, true, 0, lights},
                                  {lights + "[].type", Kind::text, true},
                                  {lights + "[].color", Kind::vector, false, 3},
                                  {lights + "[].intensity", Kind::number},
                                  {lights + "[].spot.innerConeAngle", Kind::number},
                                  {lights + "[].spot.outerConeAngle", Kind::number},
                                  {"cameras[].type", Kind::text, true},
                                  {"cameras[].name", Kind::text},
                                  {"cameras[].perspective.yfov", Kind::number, true},
                                  {"animations[].channels[].target", Kind::object, true},
                                  {"animations[].channels[].target.node", Kind::index, false, 0, "nodes"},
                                  {"animations[].channels[].target.path", Kind::text, true},
                                  {"animations[].channels[].sampler", Kind::size, true},
                                  {"animations[].samplers[].input", Kind::index, true, 0, "accessors"},
                                  {"animations[].samplers[].output", Kind::index, true, 0, "accessors"},
                                  {"animations[].samplers[].interpolation", Kind::text},
                              });
}

std::vector<Rule> makeRules()
{
    std::vector<Rule> rules = {
        {"asset", Kind::object, true},
        {"asset.version", Kind::text, true},
        {"asset.minVersion", Kind::text},
        {"extensionsUsed[]", Kind::text},
        {"extensionsRequired[]", Kind::text},
        {"buffers[].byteLength", Kind::bytes, true},
        {"buffers[].uri", Kind::text},
        {"bufferViews[].buffer", Kind::index, true, 0, "buffers"},
        {"bufferViews[].byteOffset", Kind::bytes},
        {"bufferViews[].byteLength", Kind::bytes, true},
        {"bufferViews[].byteStride", Kind::size},
        {"accessors[].bufferView", Kind::index, false, 0, "bufferViews"},
        {"accessors[].byteOffset", Kind::bytes},
        {"accessors[].count", Kind::size, true},
        {"accessors[].componentType", Kind::size, true},
        {"accessors[].normalized", Kind::truth},
        {"accessors[].type", Kind::text, true},
        {"accessors[].sparse.count", Kind::size, true},
        {"accessors[].sparse.indices", Kind::object, true},
        {"accessors[].sparse.indices.bufferView", Kind::index, true, 0, "bufferViews"},
        {"accessors[].sparse.indices.byteOffset", Kind::size},
        {"accessors[].sparse.indices.componentType", Kind::size, true},
        {"accessors[].sparse.values", Kind::object, true},
        {"accessors[].sparse.values.bufferView", Kind::index, true, 0, "bufferViews"},
        {"accessors[].sparse.values.byteOffset", Kind::size},
        {"meshes[].name", Kind::text},
        {"meshes[].primitives[].attributes", Kind::object, true},
        {"meshes[].primitives[].attributes.*", Kind::index, false, 0, "accessors"},
        {"meshes[].primitives[].targets[].*", Kind::index, false, 0, "accessors"},
        {"meshes[].primitives[].indices", Kind::index, false, 0, "accessors"},
        {"meshes[].primitives[].material", Kind::index, false, 0, "materials"},
        {"meshes[].primitives[].mode", Kind::size},
        {"images[].name", Kind::text},
        {"images[].uri", Kind::text},
        {"images[].bufferView", Kind::index, false, 0, "bufferViews"},
        {"textures[].source", Kind::index, false, 0, "images"},
        {"textures[].sampler", Kind::index, false, 0, "samplers"},
        {"samplers[].magFilter", Kind::size},
        {"samplers[].minFilter", Kind::size},
        {"samplers[].wrapS", Kind::size},
        {"samplers[].wrapT", Kind::size},
    };
    addMaterials(rules);
    addScene(rules);
    return rules;
}

/// Applies rules to a document and knows where it is, for the message.
class Checker {
public:
    Checker(const std::string& file, const json& root) : file_(file), root_(root) {}

    void apply(const Rule& rule)
    {
        rule_ = &rule;
        count_ = rule.kind == Kind::index ? targetCount() : 0;
        place_.clear();
        walk(root_, rule.path);
    }

private:
    /// Follow `path` from `value`; recursion is as deep as the rule's path is long.
    void walk(const json& value, std::string_view path)
    {
        if (path.empty())
            return checkValue(value);
        const auto dot = path.find('.');
        auto step = path.substr(0, dot);
        const auto rest = dot == path.npos ? std::string_view() : path.substr(dot + 1);
        if (!value.is_object())
            complain("an object");
        const bool overArray = step.size() > 2 && step.substr(step.size() - 2) == "[]";
        if (overArray)
            step.remove_suffix(2);
        for (auto member = step == "*" ? value.begin() : value.find(step); member != value.end(); ++member) {
            const auto parent = place_.size();
            place_ += fmt::format("{}{}", place_.empty() ? "" : ".", member.key());
            overArray ? walkArray(*member, rest) : walk(*member, rest);
            place_.resize(parent);
            if (step != "*")
                return;
        }
        if (rest.empty() && rule_->required && step != "*")
            fail("{}: {}: '{}' is missing; export the file again", file_, place(), step);
    }

    void walkArray(const json& array, std::string_view rest)
    {
        if (!array.is_array())
            complain("an array");
        for (size_t i = 0; i < array.size(); ++i) {
            const auto parent = place_.size();
            place_ += fmt::format("[{}]", i);
            walk(array[i], rest);
            place_.resize(parent);
        }
    }

    void checkValue(const json& value) const
    {
        const auto isNumber = [](const json& x) {
            return x.is_number() && std::abs(x.get<double>()) <= LARGEST_NUMBER;
        };
        const auto isCount = [&](double largest) {
            return value.is_number_unsigned() && value.get<double>() <= largest;
        };
        switch (rule_->kind) {
        case Kind::object:
            return value.is_object() ? void() : complain("an object");
        case Kind::text:
            return value.is_string() ? void() : complain("a string");
        case Kind::truth:
            return value.is_boolean() ? void() : complain("true or false");
        case Kind::size:
            return isCount(LARGEST_INTEGER) ? void() : complain("an integer from 0 to 2147483647");
        case Kind::bytes:
            return isCount(LARGEST_FILE) ? void() : complain("an integer from 0 to 4294967295");
        case Kind::number:
            return isNumber(value) ? void() : complain("a number of at most 1e30");
        case Kind::distance:
            return value.is_number() ? void() : complain("a number");
        case Kind::vector:
            if (!value.is_array() || value.size() != rule_->length ||
                !std::all_of(value.begin(), value.end(), isNumber))
                complain(fmt::format("{} numbers of at most 1e30", rule_->length));
            return;
        case Kind::index:
            if (!value.is_number_unsigned() || value.get<uint64_t>() >= count_)
                fail("{}: {}: {} does not point into {}, which has {} elements; export the file again", file_, place(),
                     printable(value.dump(), 40), rule_->target, count_);
        }
    }

    size_t targetCount() const
    {
        const json* value = &root_;
        for (std::string_view path = rule_->target; !path.empty();) {
            const auto dot = std::min(path.find('.'), path.size());
            const auto found = value->is_object() ? value->find(path.substr(0, dot)) : value->end();
            if (!value->is_object() || found == value->end())
                return 0;
            value = &*found;
            path.remove_prefix(std::min(dot + 1, path.size()));
        }
        return value->is_array() ? value->size() : 0;
    }

    std::string place() const { return place_.empty() ? "root" : printable(place_); }

    [[noreturn]] void complain(std::string_view expected) const
    {
        fail("{}: {}: must be {}; export the file again", file_, place(), expected);
    }

    const std::string& file_;
    const json& root_;
    const Rule* rule_ = nullptr;
    size_t count_ = 0;
    std::string place_;
};

/// Is a version "MAJOR.MINOR" beyond 2.0? Text that is none is not.
bool isBeyondTwo(const std::string& version)
{
    double number = 0;
    std::from_chars(version.data(), version.data() + version.size(), number);
    return number > 2;
}

/// As unifyNumbers: integers are those up to `largest`.
void unifyNumbersUpTo(json& value, double largest)
{
    if (value.is_object())
        for (auto& [name, member] : value.items())
            unifyNumbersUpTo(member, name == "extensions" || name == "extras" ? LARGEST_INTEGER : largest);
    else if (value.is_array())
        for (auto& element : value)
            unifyNumbersUpTo(element, largest);
    else if (value.is_number()) {
        const double number = value.get<double>();
        if (std::abs(number) > largest || number != std::floor(number))
            value = number;
        else if (number < 0)
            value = int64_t(number);
        else
            value = uint64_t(number);
    }
}

void checkBufferViews(const std::string& file, const json& root)
{
    const auto views = root.value("bufferViews", json::array());
    for (size_t i = 0; i < views.size(); ++i) {
        const auto& view = views[i];
        const uint64_t end = view.value("byteOffset", uint64_t(0)) + view.at("byteLength").get<uint64_t>();
        const uint64_t size = root["buffers"][view.at("buffer").get<size_t>()].at("byteLength").get<uint64_t>();
        if (end > size)
            fail("{}: bufferViews[{}]: ends at byte {} of a buffer of {}; export the file again", file, i, end, size);
    }
}

}  // namespace

void unifyNumbers(json& root)
{
    unifyNumbersUpTo(root, LARGEST_FILE);
}

void checkStructure(const std::string& file, const json& root)
{
    if (!root.is_object())
        fail("{}: not glTF: the JSON root is not an object; name a .gltf or .glb file", file);
    static const std::vector<Rule> rules = makeRules();
    Checker checker(file, root);
    for (const auto& rule : rules)
        checker.apply(rule);
    const auto version = root["asset"]["version"].get<std::string>();
    if (version.rfind("2.", 0) != 0)
        fail("{}: asset.version {}: only glTF 2 is read; export it as glTF 2.0", file, printable(version));
    // What a file needs at least; its version may be later.
    const auto least = root["asset"].value("minVersion", std::string("2.0"));
    if (isBeyondTwo(least))
        fail("{}: asset.minVersion {}: only glTF 2.0 is read; export it as glTF 2.0", file, printable(least));
    checkBufferViews(file, root);
}

}  // namespace restirpg::gltf
