// Accessors: the only place that turns a file's bytes into numbers.
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace restirpg::gltf {

namespace {

/// An accessor without a buffer view is all zeros: its count is then bounded by nothing in the file.
constexpr size_t LARGEST_ZERO_ACCESSOR = size_t(1) << 24;

/// Elements at a regular distance, every one inside its buffer.
struct Elements {
    const uint8_t* first;
    size_t stride;
};

size_t componentSize(const File& file, int accessor, uint32_t componentType, const std::string& place)
{
    switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    default:
        fail("{}: {}: accessor {} has component type {}, which glTF 2.0 does not know; export it again", file.name(),
             place, accessor, componentType);
    }
}

/// `count` elements of `size` bytes at `offset` of a buffer view, `stride` 0: tightly packed.
Elements elementsOf(const File& file, int accessor, int bufferView, size_t offset, size_t count, size_t size,
                    size_t stride, const std::string& place)
{
    const auto& view = file.model.bufferViews[size_t(bufferView)];
    stride = stride ? stride : size;
    // All of these are below 2^32 (checkStructure), so that the product fits 64 bits.
    const uint64_t end = count ? offset + uint64_t(count - 1) * stride + size : 0;
    if (end > view.byteLength)
        fail("{}: {}: accessor {} needs {} bytes of bufferViews[{}], which has {}; export it again", file.name(), place,
             accessor, end, bufferView, view.byteLength);
    return {file.model.buffers[size_t(view.buffer)].data.data() + view.byteOffset + offset, stride};
}

template <typename T>
T load(const uint8_t* bytes)
{
    T value;
    std::memcpy(&value, bytes, sizeof value);
    return value;
}

/// One component as a float [glTF 2.0, 3.11: c / 127, max(c / 127, -1) ...].
float loadFloat(const uint8_t* bytes, int componentType, bool normalized)
{
    const auto signedValue = [&](float value, float largest) {
        return normalized ? std::max(value / largest, -1.0f) : value;
    };
    const auto unsignedValue = [&](float value, float largest) { return normalized ? value / largest : value; };
    switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        return signedValue(load<int8_t>(bytes), 127);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return unsignedValue(load<uint8_t>(bytes), 255);
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        return signedValue(load<int16_t>(bytes), 32767);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return unsignedValue(load<uint16_t>(bytes), 65535);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        return unsignedValue(float(load<uint32_t>(bytes)), 4294967295.0f);
    default:
        return load<float>(bytes);
    }
}

uint32_t loadIndex(const uint8_t* bytes, uint32_t componentType)
{
    switch (componentType) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return load<uint8_t>(bytes);
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return load<uint16_t>(bytes);
    default:
        return load<uint32_t>(bytes);
    }
}

bool isIndexType(uint32_t componentType)
{
    return componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

size_t elementSize(const File& file, int index, const std::string& place)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    return componentSize(file, index, uint32_t(accessor.componentType), place) *
           size_t(tinygltf::GetNumComponentsInType(uint32_t(accessor.type)));
}

/// The elements of an accessor's own buffer view.
Elements baseOf(const File& file, int index, const std::string& place)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    return elementsOf(file, index, accessor.bufferView, accessor.byteOffset, accessor.count,
                      elementSize(file, index, place), file.model.bufferViews[size_t(accessor.bufferView)].byteStride,
                      place);
}

/// Calls `read(element, bytes)` for each element that a sparse accessor replaces.
template <typename Read>
void forEachReplaced(const File& file, int index, const std::string& place, const Read& read)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    const auto& sparse = accessor.sparse;
    const auto type = uint32_t(sparse.indices.componentType);
    if (!isIndexType(type))
        fail("{}: {}: accessor {} has sparse indices of component type {}; export it again", file.name(), place, index,
             type);
    const auto indices = elementsOf(file, index, sparse.indices.bufferView, size_t(sparse.indices.byteOffset),
                                    size_t(sparse.count), componentSize(file, index, type, place), 0, place);
    const auto replacements = elementsOf(file, index, sparse.values.bufferView, size_t(sparse.values.byteOffset),
                                         size_t(sparse.count), elementSize(file, index, place), 0, place);
    for (size_t i = 0; i < size_t(sparse.count); ++i) {
        const uint32_t element = loadIndex(indices.first + i * indices.stride, type);
        if (element >= accessor.count)
            fail("{}: {}: accessor {} replaces element {} of {}; export it again", file.name(), place, index, element,
                 accessor.count);
        read(element, replacements.first + i * replacements.stride);
    }
}

/// Calls `read(element, bytes)` for each element that the file holds: those of the buffer view, then those that the
/// sparse part replaces. The others are zeros.
template <typename Read>
void forEachElement(const File& file, int index, const std::string& place, const Read& read)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    if (accessor.bufferView >= 0) {
        const auto elements = baseOf(file, index, place);
        for (size_t i = 0; i < accessor.count; ++i)
            read(i, elements.first + i * elements.stride);
    }
    if (accessor.sparse.isSparse)
        forEachReplaced(file, index, place, read);
}

const char* typeName(int type)
{
    switch (type) {
    case TINYGLTF_TYPE_SCALAR:
        return "SCALAR";
    case TINYGLTF_TYPE_VEC2:
        return "VEC2";
    case TINYGLTF_TYPE_VEC3:
        return "VEC3";
    case TINYGLTF_TYPE_VEC4:
        return "VEC4";
    default:
        return "a matrix";
    }
}

}  // namespace

void checkAccessor(const File& file, int index, const std::string& place)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    if (accessor.bufferView >= 0)
        baseOf(file, index, place);
    else if (accessor.count > LARGEST_ZERO_ACCESSOR)
        fail("{}: {}: accessor {} has {} elements but no data; export it again", file.name(), place, index,
             accessor.count);
}

std::vector<float> readFloats(const File& file, int index, const std::string& place, std::initializer_list<int> types,
                              size_t most)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    if (std::find(types.begin(), types.end(), accessor.type) == types.end())
        fail("{}: {}: accessor {} is {}, not {}; export it again", file.name(), place, index, typeName(accessor.type),
             typeName(*types.begin()));
    checkAccessor(file, index, place);
    const size_t size = componentSize(file, index, uint32_t(accessor.componentType), place);
    const size_t components = size_t(tinygltf::GetNumComponentsInType(uint32_t(accessor.type)));
    const size_t count = std::min(accessor.count, most);
    std::vector<float> values(count * components);
    forEachElement(file, index, place, [&](size_t element, const uint8_t* bytes) {
        for (size_t c = 0; c < components && element < count; ++c)
            values[element * components + c] = loadFloat(bytes + c * size, accessor.componentType, accessor.normalized);
    });
    const auto bad = std::find_if(values.begin(), values.end(), [](float x) { return !std::isfinite(x); });
    if (bad != values.end())
        fail("{}: {}: element {} of accessor {} is not a finite number; repair the mesh and export it again",
             file.name(), place, size_t(bad - values.begin()) / components, index);
    return values;
}

std::vector<uint32_t> readIndices(const File& file, int index, const std::string& place)
{
    const auto& accessor = file.model.accessors[size_t(index)];
    const auto type = uint32_t(accessor.componentType);
    if (accessor.type != TINYGLTF_TYPE_SCALAR || !isIndexType(type))
        fail("{}: {}: accessor {} is not a list of unsigned integers; export it again", file.name(), place, index);
    checkAccessor(file, index, place);
    std::vector<uint32_t> indices(accessor.count);
    forEachElement(file, index, place,
                   [&](size_t element, const uint8_t* bytes) { indices[element] = loadIndex(bytes, type); });
    return indices;
}

}  // namespace restirpg::gltf
