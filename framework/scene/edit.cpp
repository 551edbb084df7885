#include "scene/edit.h"

#include "core/error_kinds.h"
#include "core/nearest.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace restirpg {
namespace {

constexpr float BOUNDLESS = std::numeric_limits<float>::max();

/// The things of one kind: "materials", and what each is called in a path.
struct Kind {
    std::string name;
    std::vector<std::string> names;  ///< as in the file
    std::vector<std::string> keys;
};

bool isNumber(const std::string& text)
{
    return !text.empty() && text.find_first_not_of("0123456789") == std::string::npos;
}

Kind makeKind(const std::string& name, std::vector<std::string> names)
{
    std::map<std::string, size_t> uses;
    for (const auto& one : names)
        ++uses[one];
    Kind kind{name, std::move(names), {}};
    for (size_t i = 0; i < kind.names.size(); ++i) {
        const auto& one = kind.names[i];
        const bool tells = !one.empty() && !isNumber(one) && uses[one] == 1;
        kind.keys.push_back(tells ? one : std::to_string(i));
    }
    return kind;
}

Kind materialsOf(const Scene& scene)
{
    return makeKind("materials", scene.materialNames);
}

Kind lightsOf(const Scene& scene)
{
    std::vector<std::string> names;
    for (const auto& light : scene.punctualLights)
        names.push_back(scene.nodes[light.node].name);
    return makeKind("lights", std::move(names));
}

Kind nodesOf(const Scene& scene)
{
    std::vector<std::string> names;
    for (const auto& node : scene.nodes)
        names.push_back(node.name);
    return makeKind("nodes", std::move(names));
}

glm::dvec3 asVector(const std::vector<double>& values)
{
    return {values[0], values[1], values[2]};
}

std::vector<double> asValues(const glm::vec3& v)
{
    return {v.x, v.y, v.z};
}

std::vector<double> asRows(const glm::dmat4& matrix)
{
    std::vector<double> rows;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            rows.push_back(matrix[column][row]);
    return rows;
}

glm::dmat4 fromRows(const std::vector<double>& rows)
{
    glm::dmat4 matrix;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[column][row] = rows[size_t(row) * 4 + size_t(column)];
    return matrix;
}

void setEmission(Material& material, const glm::vec3& emission)
{
    material.emission = emission;
    material.flags &= ~MATERIAL_EMISSIVE;
    if (emission != glm::vec3(0))
        material.flags |= MATERIAL_EMISSIVE;
}

void listMaterials(const Scene& scene, std::vector<SceneParameter>& list)
{
    const auto keys = materialsOf(scene).keys;
    for (size_t i = 0; i < keys.size(); ++i) {
        const auto& material = scene.materials[i];
        const std::string place = "materials." + keys[i] + ".";
        const auto number = [&](const char* name, float Material::*member) {
            list.push_back({place + name, {material.*member}, 0, 1, [=](Scene& edited, const auto& values) {
                                edited.materials[i].*member = float(values[0]);
                            }});
        };
        list.push_back({place + "base_color", asValues(material.baseColor), 0, 1,
                        [=](Scene& edited, const auto& v) { edited.materials[i].baseColor = asVector(v); }});
        number("metallic", &Material::metallic);
        number("roughness", &Material::roughness);
        number("transmission", &Material::transmission);
        list.push_back({place + "emission", asValues(material.emission), 0, BOUNDLESS,
                        [=](Scene& edited, const auto& v) { setEmission(edited.materials[i], asVector(v)); }});
    }
}

void listLights(const Scene& scene, std::vector<SceneParameter>& list)
{
    const auto keys = lightsOf(scene).keys;
    for (size_t i = 0; i < keys.size(); ++i)
        list.push_back({"lights." + keys[i] + ".intensity", asValues(scene.punctualLights[i].intensity), 0, BOUNDLESS,
                        [=](Scene& edited, const auto& v) { edited.punctualLights[i].intensity = asVector(v); }});
    if (scene.environment)
        list.push_back({"environment.radiance", asValues(scene.environment->radiance), 0, BOUNDLESS,
                        [](Scene& edited, const auto& v) { edited.environment->radiance = asVector(v); }});
}

void listNodes(const Scene& scene, const std::vector<std::optional<glm::mat4>>& overrides,
               std::vector<SceneParameter>& list)
{
    const auto keys = nodesOf(scene).keys;
    for (size_t i = 0; i < keys.size(); ++i) {
        const bool given = i < overrides.size() && overrides[i];
        const auto matrix = given ? glm::dmat4(*overrides[i]) : localMatrix(scene.nodes[i]);
        list.push_back({"nodes." + keys[i] + ".matrix", asRows(matrix), -BOUNDLESS, BOUNDLESS,
                        [=](Scene& edited, const auto& values) { edited.nodes[i].matrix = fromRows(values); }});
    }
}

/// Names may hold dots: the kind stands before the first, the value's name after the last.
std::string middleOf(const std::string& path)
{
    const auto first = path.find('.'), last = path.rfind('.');
    return first == last ? "" : path.substr(first + 1, last - first - 1);
}

[[noreturn]] void refusePath(const Scene& scene, const std::string& path, const std::vector<SceneParameter>& list)
{
    const auto asked = middleOf(path);
    for (const auto& kind : {materialsOf(scene), lightsOf(scene), nodesOf(scene)}) {
        if (path.rfind(kind.name + ".", 0) != 0)
            continue;
        if (isNumber(asked) && (asked.size() > 9 || std::stoul(asked) >= kind.keys.size()))
            failAs<WrongIndex>("{}: '{}': the scene has {} {}, counted from 0", scene.file.string(), path,
                               kind.keys.size(), kind.name);
        std::string places;
        for (size_t i = 0; i < kind.names.size(); ++i)
            if (kind.names[i] == asked && kind.keys[i] != asked)
                places += (places.empty() ? "" : ", ") + std::to_string(i);
        if (!places.empty())
            failAs<WrongValue>("{}: '{}': several {} have that name; name one by its place: {}", scene.file.string(),
                               path, kind.name, places);
        if (isNumber(asked) && kind.keys[std::stoul(asked)] != asked)
            failAs<WrongValue>("{}: '{}': of {} this is called '{}'", scene.file.string(), path, kind.name,
                               kind.keys[std::stoul(asked)]);
    }
    std::vector<std::string> paths;
    for (const auto& parameter : list)
        paths.push_back(parameter.path);
    const auto guess = didYouMean(path, paths);
    failAs<WrongValue>("{}: the scene has no parameter '{}'{}{}", scene.file.string(), path,
                       guess.empty() ? "; parameters() lists what it has" : "; ", guess);
}

void checkValues(const Scene& scene, const SceneParameter& parameter, const std::vector<double>& values)
{
    if (values.size() != parameter.values.size())
        failAs<WrongValue>("{}: '{}' takes {} number{}, not {}", scene.file.string(), parameter.path,
                           parameter.values.size(), parameter.values.size() == 1 ? "" : "s", values.size());
    for (const double value : values)
        if (!(value >= parameter.least && value <= parameter.most)) {
            if (parameter.most == BOUNDLESS)
                failAs<WrongValue>("{}: '{}' cannot be {}: must be finite{}", scene.file.string(), parameter.path,
                                   value, parameter.least == 0 ? " and at least 0" : "");
            failAs<WrongValue>("{}: '{}' cannot be {}: must lie between {} and {}", scene.file.string(), parameter.path,
                               value, parameter.least, parameter.most);
        }
}

}  // namespace

std::vector<SceneParameter> parametersOf(const Scene& scene, const std::vector<std::optional<glm::mat4>>& overrides)
{
    std::vector<SceneParameter> list;
    listMaterials(scene, list);
    listLights(scene, list);
    listNodes(scene, overrides, list);
    return list;
}

void editScene(Scene& scene, const std::map<std::string, std::vector<double>>& values)
{
    const auto list = parametersOf(scene);
    std::vector<std::pair<const SceneParameter*, std::vector<double>>> edits;
    for (const auto& [path, given] : values) {
        const auto found = std::find_if(list.begin(), list.end(),
                                        [&path = path](const auto& parameter) { return parameter.path == path; });
        if (found == list.end())
            refusePath(scene, path, list);
        const bool grey = given.size() == 1 && found->values.size() == 3;
        edits.emplace_back(&*found, grey ? std::vector<double>(3, given[0]) : given);
        checkValues(scene, *found, edits.back().second);
    }
    for (const auto& [parameter, numbers] : edits)
        parameter->set(scene, numbers);
}

std::map<std::string, std::vector<double>> matricesOf(const Scene& scene,
                                                      const std::vector<std::optional<glm::mat4>>& overrides)
{
    const auto keys = nodesOf(scene).keys;
    std::map<std::string, std::vector<double>> matrices;
    for (size_t i = 0; i < overrides.size(); ++i)
        if (overrides[i])
            matrices["nodes." + keys[i] + ".matrix"] = asRows(*overrides[i]);
    return matrices;
}

std::optional<size_t> nodeOfPath(const Scene& scene, const std::string& path)
{
    if (path.rfind("nodes.", 0) != 0)
        return {};
    const auto keys = nodesOf(scene).keys;
    const auto found = std::find(keys.begin(), keys.end(), middleOf(path));
    return found == keys.end() ? std::nullopt : std::optional(size_t(found - keys.begin()));
}

}  // namespace restirpg
