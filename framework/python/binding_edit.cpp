// What can be changed of a renderer's scene.
#include "binding.h"

#include "core/error_kinds.h"
#include "shared_renderer.h"

#include <fmt/ranges.h>

#include <map>

namespace restirpg::python {
namespace {

constexpr const char* PARAMETERS = R"(What edit() can change of the scene, as it is: {path: value}.

A value is a number, an RGB triple, or a matrix (4, 4) of column vectors. Paths:
  materials.NAME.base_color, .metallic, .roughness, .transmission   0 to 1; textures multiply them
  materials.NAME.emission                                           radiance, W/sr/m^2; a texture multiplies it
  lights.NAME.intensity      of the light of the node NAME, colour included: W/sr; of a directional light W/m^2
  environment.radiance       W/sr/m^2, or the scale of its picture
  nodes.NAME.matrix          towards the node's parent
Where a name is empty, a number or not the only one of its kind, its place stands there, counted from 0.)";

constexpr const char* EDIT =
    R"(Change values of the scene for this renderer alone: a dictionary as parameters() gives it.

All are changed or none. The picture is that of a scene file with these values, to the byte: the table of lights, the
probabilities with which they are selected and the acceleration structure follow. It implies cut(). One number stands for
three equal ones. The first edit makes a copy of the scene and uploads it anew, as one of a node always does: move_node() is
cheaper for what moves every frame. Later ones of materials, lights and the environment upload these alone. A node that is
given a matrix is no longer animated. Skins stay in the pose in which they were loaded, and so do the camera and the light
that were added to a file without any.
Raises ValueError, or IndexError for a place that is not there.)";

/// Numbers of a Python object, row by row.
std::vector<double> asNumbers(const std::string& path, const py::handle& value)
{
    const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(value);
    if (!array) {
        PyErr_Clear();
        failAs<WrongValue>("'{}' cannot be {}: it takes numbers", path, py::repr(value).cast<std::string>());
    }
    return {array.data(), array.data() + array.size()};
}

void edit(SharedRenderer& shared, const py::dict& values)
{
    std::map<std::string, std::vector<double>> numbers;
    for (const auto& [key, value] : values) {
        if (!py::isinstance<py::str>(key))
            failAs<WrongValue>("{} is no path of a parameter, as parameters() lists them",
                               py::repr(key).cast<std::string>());
        const auto path = key.cast<std::string>();
        numbers[path] = asNumbers(path, value);
    }
    shared.run([&](Renderer& renderer) { renderer.edit(numbers); });
}

py::dict parameters(SharedRenderer& shared)
{
    py::dict result;
    const auto all = shared.run([](const Renderer& renderer) { return renderer.parameters(); });
    for (const auto& [path, json] : all.items()) {
        const auto values = json.get<std::vector<double>>();
        if (values.size() == 1) {
            result[py::str(path)] = values[0];
            continue;
        }
        py::list list;
        for (size_t i = 0; i < values.size(); ++i) {
            if (values.size() == 16 && i % 4 == 0)
                list.append(
                    py::cast(std::vector<double>(values.begin() + ptrdiff_t(i), values.begin() + ptrdiff_t(i) + 4)));
            else if (values.size() != 16)
                list.append(values[i]);
        }
        result[py::str(path)] = list;
    }
    return result;
}

}  // namespace

void bindEdits(py::class_<SharedRenderer>& renderer)
{
    renderer.def("parameters", &parameters, PARAMETERS).def("edit", &edit, EDIT, py::arg("values"));
}

}  // namespace restirpg::python
