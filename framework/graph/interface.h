// What a pass takes, makes and lets a user turn. A pass declares it once in Pass::describe; the graph, the command
// line, Python, the EXR header and the docs read it here.
#pragma once

#include "graph/knob.h"

#include <algorithm>
#include <cstdint>
#include <functional>
#include <limits>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

namespace restirpg {

class Buffer;  // gpu/buffer.h

/// What travels along an edge. A name stands for what the bytes mean, not for how many there are: an input takes the
/// outputs that have its type's name, or whose family has that name, and whose size is that of the input's type where
/// it tells one.
struct PortType {
    std::string name;  ///< "Image3", "Surface", "GridGuide", ...
    /// > 0: a float image (H, W, channels), readable as a NumPy array and writable as an EXR layer
    uint32_t channels = 0;
    uint32_t bytesPerPixel = 0;
    /// When set, bytes of the whole resource, whatever the image size (read after knobs are set)
    std::function<uint64_t()> fixedBytes = {};
    /// When set, stands for bytesPerPixel: a size that follows a knob (read after knobs are set)
    std::function<uint64_t()> pixelBytes = {};
    /// GLSL that comes with the resource (how to read a guide): the reader compiles it in, see In::module
    std::string module = {};
    /// An output's type: the name of all types like it ("Guide"); an input of that name takes any of them
    std::string family = {};
    /// When set, bytes of one item: the resource is an array of them, which kernels index by 32 bits
    uint32_t itemBytes = 0;

    uint64_t bytes(uint32_t width, uint32_t height) const
    {
        return fixedBytes ? fixedBytes() : (pixelBytes ? pixelBytes() : bytesPerPixel) * width * height;
    }

    /// Does an input of this type take what `output` is?
    bool takes(const PortType& output) const { return output.name == name || output.family == name; }

    /// "16 B/pixel", "1024 B", or what follows another port's size, as long as that is not known.
    std::string sizeText() const
    {
        if (bytes(1, 1) == 0)
            return "as wired";
        return fixedBytes ? std::to_string(fixedBytes()) + " B" : std::to_string(bytes(1, 1)) + " B/pixel";
    }
};

/// The member variable behind a port. The executor points it at this frame's buffer before Pass::record.
template <typename Resource>
struct In {
    bool wired = false;  ///< set with the graph, before Pass::check
    const Resource* resource = nullptr;  ///< of this frame
    std::string module;  ///< PortType::module of the output wired to it; set before Pass::build
    /// Bytes that the output wired to it has per pixel, as its maker's knobs are now; set with the graph, before
    /// Pass::check.
    std::function<uint64_t()> pixelBytes = [] { return uint64_t(0); };
    /// A delayed input without history (first frame, after a start or a cut): its buffer is zeroed
    bool empty = false;
    explicit operator bool() const { return wired; }
    const Resource* operator->() const { return resource; }
    /// How many T an input of type anyPerPixel has per pixel.
    template <typename T>
    uint32_t countPerPixel() const
    {
        return uint32_t(pixelBytes() / sizeof(T));
    }
};

/// Float image of 1 to 4 channels, row by row from the top, scalar layout.
inline PortType image(uint32_t channels)
{
    return {"Image" + std::to_string(channels), channels, 4 * channels, {}};
}

/// Where the point of a pixel was in the frame before, minus where it is: an image of 2 channels, in pixels, x right
/// and y down. NaN: it was behind the camera.
inline PortType motionVectors()
{
    return {"Motion", 2, 2 * sizeof(float), {}};
}

/// One T for each pixel, row by row; `name` is the type's name.
template <typename T>
PortType perPixel(const std::string& name)
{
    return {name, 0, uint32_t(sizeof(T)), {}};
}

/// As many T per pixel as `count` says: T[height * width][count].
template <typename T>
PortType severalPerPixel(const std::string& name, std::function<uint64_t()> count)
{
    PortType type{name, 0, 0, {}, [count = std::move(count)] { return sizeof(T) * count(); }};
    type.itemBytes = sizeof(T);
    return type;
}

/// T of any number per pixel, which the reader takes from In::countPerPixel.
inline PortType anyPerPixel(const std::string& name)
{
    return {name};
}

/// A resource whose size does not follow the image.
inline PortType fixedSize(const std::string& name, std::function<uint64_t()> bytes)
{
    return {name, 0, 0, std::move(bytes)};
}

/// A guide of the type `name`: `layout` tells its size, `module` is the GLSL file that gives it a meaning (see
/// shaders/guide/guide.glsl).
inline PortType guide(const std::string& name, PortType layout, std::string module)
{
    layout.name = name;
    layout.module = std::move(module);
    layout.family = "Guide";
    return layout;
}

/// For inputs that take any guide and read it by its module.
inline PortType anyGuide()
{
    return {"Guide", 0, 0, {}};
}

template <typename Resource>
struct Out {
    bool wired = false;  ///< somebody reads this output; set with the graph, before Pass::check
    Resource* resource = nullptr;  ///< already set in Pass::build
    explicit operator bool() const { return wired; }
    Resource* operator->() const { return resource; }
};

/// Which frame's output an input takes.
enum class Moment {
    any,
    thisFrame,
    frameBefore,  ///< wired with prev()
};

struct InputPort {
    std::string name;
    PortType type;
    std::string meaning;
    bool optional = false;
    In<Buffer>* target = nullptr;
    Moment moment = Moment::any;
};

struct OutputPort {
    std::string name;
    PortType type;
    std::string meaning;
    Out<Buffer>* target = nullptr;
};

/// Collects a pass's declarations. Names are lower_snake_case; meanings are one sentence, no full stop.
class Interface {
public:
    void input(const std::string& name, In<Buffer>& target, PortType type, const std::string& meaning);
    void optionalInput(const std::string& name, In<Buffer>& target, PortType type, const std::string& meaning);
    /// Marks the input declared last: it must be wired to an output of this frame, not with prev().
    void ofThisFrame();
    /// Marks the input declared last: it must be wired with prev(), to an output of the frame before.
    void ofFrameBefore();
    /// A graph wires all of these optional inputs, declared before, or none.
    void together(std::vector<std::string> names);
    void output(const std::string& name, Out<Buffer>& target, PortType type, const std::string& meaning);

    void knob(const std::string& name, bool& target, const std::string& meaning);
    void knob(const std::string& name, int32_t& target, int32_t minimum, int32_t maximum, const std::string& meaning);
    void knob(const std::string& name, uint32_t& target, uint32_t minimum, uint32_t maximum,
              const std::string& meaning);
    void knob(const std::string& name, float& target, float minimum, float maximum, const std::string& meaning);
    void knob(const std::string& name, std::string& target, const std::string& meaning);
    /// A knob whose values have names: the user gives a name, `target` is its value, an enumerator or a constant that
    /// kernels know.
    template <typename Value>
    void choice(const std::string& name, Value& target,
                std::type_identity_t<std::vector<std::pair<std::string, Value>>> choices, const std::string& meaning)
    {
        std::vector<std::string> names;
        std::vector<Value> values;
        for (auto& [choiceName, value] : choices) {
            names.push_back(choiceName);
            values.push_back(value);
        }
        Knob::Selection selection{
            [&target, values] { return size_t(std::find(values.begin(), values.end(), target) - values.begin()); },
            [&target, values](size_t place) { target = values[place]; }};
        addChoice(name, std::move(selection), std::move(names), meaning);
    }
    /// Marks the knob declared last: a change of it rebuilds the pass (kernels, buffer sizes) and empties all
    /// histories. Also for knobs whose change makes existing histories wrong, because these hold other paths or other
    /// units.
    void structural();

    const std::vector<InputPort>& inputs() const { return inputs_; }
    const std::vector<std::vector<std::string>>& groups() const { return groups_; }  ///< of inputs, see together()
    const std::vector<OutputPort>& outputs() const { return outputs_; }
    std::vector<Knob>& knobs() { return knobs_; }
    const std::vector<Knob>& knobs() const { return knobs_; }

private:
    void addChoice(const std::string& name, Knob::Selection selection, std::vector<std::string> choices,
                   const std::string& meaning);

    std::vector<InputPort> inputs_;
    std::vector<std::vector<std::string>> groups_;
    std::vector<OutputPort> outputs_;
    std::vector<Knob> knobs_;
};

}  // namespace restirpg
