// What a user may change of a scene that was read: materials, lights, the environment and nodes, each value by its
// path.
#pragma once

#include "scene/scene.h"

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace restirpg {

/// One value, at a path as "materials.Wall.base_color". Materials are called by their names, lights and nodes by that
/// of their node; where a name is empty, a number or not the only one of its kind, by their place from 0.
struct SceneParameter {
    std::string path;
    std::vector<double> values;  ///< matrices row by row
    float least;
    float most;
    std::function<void(Scene&, const std::vector<double>&)> set;
};

/// materials.M.{base_color, metallic, roughness, transmission, emission}, lights.L.intensity, environment.radiance,
/// nodes.N.matrix; meanings and units as in Scene.
/// `overrides`: local matrices of nodes that a user moved, as poseNodes has them.
std::vector<SceneParameter> parametersOf(const Scene& scene,
                                         const std::vector<std::optional<glm::mat4>>& overrides = {});

/// Change values by their paths; one number stands for three equal ones. Throws WrongValue or WrongIndex naming the
/// path; the scene is as before then.
void editScene(Scene& scene, const std::map<std::string, std::vector<double>>& values);

/// The matrices of the nodes that a user moved, row by row, by their paths as editScene takes them.
std::map<std::string, std::vector<double>> matricesOf(const Scene& scene,
                                                      const std::vector<std::optional<glm::mat4>>& overrides);

/// The place in Scene::nodes that a path is of; nothing where it is of no node.
std::optional<size_t> nodeOfPath(const Scene& scene, const std::string& path);

}  // namespace restirpg
