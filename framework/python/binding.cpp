// The Python module restirpg._native: scene, graph, renderer and images for scripts, the harness and notebooks.
#include "binding.h"

#include "core/error_kinds.h"
#include "core/paths.h"
#include "graph/pass.h"
#include "render/version.h"

namespace restirpg::python {

py::array_t<float> toArray(Image&& image)
{
    const std::vector<py::ssize_t> shape = {py::ssize_t(image.height), py::ssize_t(image.width),
                                            py::ssize_t(image.channels)};
    auto* data = new std::vector<float>(std::move(image.data));
    const py::capsule owner(data, [](void* pointer) { delete static_cast<std::vector<float>*>(pointer); });
    return py::array_t<float>(shape, data->data(), owner);
}

Image toImage(const FloatArray& array, const std::string& what)
{
    if ((array.ndim() != 2 && array.ndim() != 3) || array.size() == 0)
        failAs<WrongValue>("{} must be an array (H, W) or (H, W, C) with pixels, not of shape {}", what,
                           py::str(py::tuple(array.attr("shape"))).cast<std::string>());
    const auto channels = array.ndim() == 3 ? array.shape(2) : 1;
    return {uint32_t(array.shape(1)), uint32_t(array.shape(0)), uint32_t(channels),
            std::vector<float>(array.data(), array.data() + array.size())};
}

py::object toPython(const nlohmann::json& value)
{
    return py::module_::import("json").attr("loads")(
        value.dump(-1, ' ', true, nlohmann::json::error_handler_t::replace));
}

nlohmann::json toJson(const py::object& value)
{
    const bool numpyScalar = py::hasattr(value, "item") && py::hasattr(value, "dtype");
    const py::object plain = numpyScalar ? value.attr("item")() : value;
    try {
        const auto dumps = py::module_::import("json").attr("dumps");
        return nlohmann::json::parse(dumps(plain, py::arg("allow_nan") = false).cast<std::string>());
    } catch (const py::error_already_set& error) {
        if (!error.matches(PyExc_TypeError) && !error.matches(PyExc_ValueError))
            throw;
        failAs<WrongValue>("{} is not a number, truth value or text", py::repr(value).cast<std::string>());
    }
}

}  // namespace restirpg::python

PYBIND11_MODULE(_native, module)
{
    namespace py = pybind11;
    module.doc() =
        "The renderer: load_scene, load_graph, Renderer, and images as NumPy arrays.\n\n"
        "A mistake of the user raises restirpg.Error, whose text names the file, the place and the mend. Threads may\n"
        "share a Renderer: their calls take turns. A process that was forked after a Renderer was made can make none.";
    auto& base = py::register_exception<restirpg::Error>(module, "Error", PyExc_RuntimeError);
    base.doc() = "A user's mistake or an unusable file or device: its text names the place and the mend.";
    const auto kind = [&](PyObject* builtin) { return py::make_tuple(base, py::handle(builtin)); };
    py::register_exception<restirpg::MissingFile>(module, "MissingFileError", kind(PyExc_FileNotFoundError)).doc() =
        "A file to read is not there.";
    py::register_exception<restirpg::WrongValue>(module, "WrongValueError", kind(PyExc_ValueError)).doc() =
        "A value that was given is of a wrong type, out of range or no name of anything.";
    py::register_exception<restirpg::WrongIndex>(module, "WrongIndexError", kind(PyExc_IndexError)).doc() =
        "A place that was given lies beyond the end of a list.";
    module.attr("__version__") = restirpg::VERSION;
    module.attr("COMMIT") = restirpg::COMMIT;
    module.attr("PLUGIN_ABI") = restirpg::PLUGIN_ABI;
    // None or empty where a program with a Python inside does not say.
    if (const py::object program = py::module_::import("sys").attr("executable"); py::cast<bool>(py::bool_(program)))
        restirpg::setPythonInterpreter(program.cast<std::string>());
    restirpg::python::bindImage(module);
    restirpg::python::bindPass(module);
    restirpg::python::bindScene(module);
    restirpg::python::bindRenderer(module);
    // Users meet these as members of the package.
    for (const auto& [name, member] : module.attr("__dict__").cast<py::dict>())
        if (py::isinstance<py::type>(member))
            py::setattr(member, "__module__", py::str("restirpg"));
}
