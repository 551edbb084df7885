// Images: EXR, PNG and the error metrics.
#include "binding.h"

#include "core/error_kinds.h"
#include "core/paths.h"
#include "image/metrics.h"

#include <cmath>

namespace restirpg::python {
namespace {

namespace fs = std::filesystem;

constexpr const char* READ_EXR =
    R"(Read the colour channels of an EXR file as a float32 array (H, W, 3): linear, rows from the top.

R, G, B of the plain layer, or of `layer`; a layer with the one channel Y three times; one with X, Y as X, Y, 0.
Raises Error for a file that is missing, damaged, deep or has no such layer.)";

constexpr const char* READ_ATTRIBUTES =
    R"(The text attributes of an EXR file's header, as a dictionary. Bytes that are no UTF-8 become \xff.)";

constexpr const char* WRITE_EXR =
    R"(Write float arrays of one size as the layers of an EXR file (ZIP), whole or not at all.

layers: {name: array (H, W) or (H, W, C)} with 1 to 4 channels; the layer named "" has the plain channels R, G, B.
half: store half floats, which saturate at 65504. attributes: {name: text} for the header.)";

constexpr const char* WRITE_PNG =
    R"(Write a linear Rec.709 image (H, W, 3) or (H, W) as an 8-bit PNG for a display, whole or not at all.

exposure: stops. config: an OpenColorIO file (default: a small one of ours, with the views "Standard" and "ACES" of the
display "sRGB"); display, view: of that config (default: its own defaults). Pixels with NaN or infinity become black.)";

constexpr const char* MEASURE_ERRORS = R"(Errors of `image` against `reference`, both linear (H, W, 3), as a dictionary.

mape: mean of |I - R| / (0.01 mean(Y_R) + Y_R), Y the Rec.709 luminance (Zeng et al. 2025, footnote 4).
relmse: mean of (I - R)^2 / (R^2 + 0.01). rmse: root of the mean squared difference.
bias: (mean(I) - mean(R)) / mean(R), signed. All means are over pixels and channels.
invalid: number of pixels with NaN or infinity in either image, left out of all means.)";

/// Other programs write other encodings.
py::str asText(const std::string& bytes)
{
    const auto text = PyUnicode_DecodeUTF8(bytes.data(), py::ssize_t(bytes.size()), "backslashreplace");
    if (!text)
        throw py::error_already_set();
    return py::reinterpret_steal<py::str>(text);
}

py::dict readAttributes(const fs::path& file)
{
    py::dict result;
    for (const auto& [name, value] : readExrAttributes(file))
        result[asText(name)] = asText(value);
    return result;
}

void writeLayers(const fs::path& file, const py::dict& layers, bool half,
                 const std::map<std::string, std::string>& attributes)
{
    std::vector<Layer> images;
    for (const auto& [name, array] : layers) {
        const auto text = py::str(name).cast<std::string>();
        const auto numbers = FloatArray::ensure(array);
        if (!numbers)
            failAs<WrongValue>("layer '{}' must be an array of numbers, not {}", text,
                               printable(py::repr(array).cast<std::string>()));
        images.push_back({text, toImage(numbers, "layer '" + text + "'")});
    }
    requireExtension(file, ".exr");
    const PixelType type = half ? PixelType::half : PixelType::full;
    py::gil_scoped_release release;
    writeExr(file, images, type, attributes);
}

py::dict errorsOf(const FloatArray& image, const FloatArray& reference)
{
    const Errors errors = measureErrors(toImage(image, "image"), toImage(reference, "reference"));
    py::dict result;
    result["mape"] = errors.mape;
    result["relmse"] = errors.relMse;
    result["rmse"] = errors.rmse;
    result["bias"] = errors.bias;
    result["invalid"] = errors.invalid;
    return result;
}

}  // namespace

void bindImage(py::module_& module)
{
    using namespace py::literals;
    module.def(
        "read_exr", [](const fs::path& file, const std::string& layer) { return toArray(readExr(file, layer)); },
        READ_EXR, "file"_a, "layer"_a = "");
    module.def("read_exr_attributes", &readAttributes, READ_ATTRIBUTES, "file"_a);
    module.def("write_exr", &writeLayers, WRITE_EXR, "file"_a, "layers"_a, "half"_a = false,
               "attributes"_a = std::map<std::string, std::string>());
    module.def(
        "write_png",
        [](const fs::path& file, const FloatArray& image, float exposure, const std::string& config,
           const std::string& display, const std::string& view) {
            requireExtension(file, ".png");
            if (!std::isfinite(exposure))
                failAs<WrongValue>("exposure {}: must be finite", exposure);
            writePng(file, toImage(image, "image"), {config, display, view, exposure});
        },
        WRITE_PNG, "file"_a, "image"_a, "exposure"_a = 0.0f, "config"_a = "", "display"_a = "", "view"_a = "");
    module.def("measure_errors", &errorsOf, MEASURE_ERRORS, "image"_a, "reference"_a);
}

}  // namespace restirpg::python
