// What the files of the binding module share: conversions between Python and the framework's types.
#pragma once

#include "image/image.h"

#include <nlohmann/json.hpp>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

namespace restirpg::python {

namespace py = pybind11;

/// What load_graph returns: a graph as data, checked for shape only.
struct GraphDescription {
    nlohmann::json json;
    std::filesystem::path file;  ///< that it was read from
};

/// A float32 array; what is another type or layout is copied.
using FloatArray = py::array_t<float, py::array::c_style | py::array::forcecast>;

/// (H, W, C) array that takes over the image's memory.
py::array_t<float> toArray(Image&& image);
/// The image in an (H, W) or (H, W, C) array; throws Error naming `what` for other shapes.
Image toImage(const FloatArray& array, const std::string& what);

/// Dictionaries, lists, numbers and text.
py::object toPython(const nlohmann::json& value);
/// As toPython, the other way; NumPy scalars too. Throws Error for what JSON cannot hold.
nlohmann::json toJson(const py::object& value);

void bindImage(py::module_& module);
void bindPass(py::module_& module);
void bindScene(py::module_& module);
void bindRenderer(py::module_& module);

}  // namespace restirpg::python
