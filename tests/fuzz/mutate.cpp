// Changes that keep a file's container valid, so that what lies inside is reached: edits of parsed JSON, and PNG chunks
// whose checksums fit.
#include "targets.h"

#include <nlohmann/json.hpp>

#include <cstring>
#include <set>
#include <stdexcept>

#include <zlib.h>

extern "C" size_t LLVMFuzzerMutate(uint8_t* data, size_t size, size_t largest);

namespace restirpg::fuzz {
namespace {

using nlohmann::json;

constexpr int DEEPEST = 100;  ///< levels that are edited; deeper files are left to changes of bytes
constexpr size_t LARGEST_GROWTH = 256;  ///< bytes

/// All places of a document, and the names of all members.
struct Places {
    std::vector<json*> values;
    std::set<std::string> names;

    void collect(json& value)
    {
        values.push_back(&value);
        if (value.is_object())
            for (const auto& member : value.items())
                names.insert(member.key());
        if (value.is_structured())
            for (auto& element : value)
                collect(element);
    }
};

size_t pick(std::mt19937& random, size_t count)
{
    return count ? random() % count : 0;
}

json awkward(std::mt19937& random)
{
    static const std::vector<json> VALUES = {-1,
                                             0,
                                             1,
                                             2,
                                             3,
                                             4,
                                             255,
                                             5120,
                                             5121,
                                             5122,
                                             5123,
                                             5125,
                                             5126,
                                             9728,
                                             33071,
                                             1000000,
                                             2147483647,
                                             2147483648u,
                                             4294967295u,
                                             18446744073709551615u,
                                             1e30,
                                             -1e30,
                                             1e300,
                                             1e-30,
                                             1e-45,
                                             0.5,
                                             -0.0,
                                             nullptr,
                                             true,
                                             false,
                                             "",
                                             "x",
                                             "SCALAR",
                                             "VEC2",
                                             "VEC3",
                                             "VEC4",
                                             "MAT4",
                                             "MASK",
                                             "BLEND",
                                             "STEP",
                                             "CUBICSPLINE",
                                             "weights",
                                             "translation",
                                             "../x",
                                             "%2e%2e/x",
                                             "data:application/octet-stream;base64,AAAA",
                                             "data:image/png;base64,",
                                             "a\xcc\x88\x01\n",
                                             json::array(),
                                             json::object(),
                                             {1, 2},
                                             {1, 2, 3},
                                             {0, 0, 0, 0},
                                             {{"a", 1}}};
    return VALUES[pick(random, VALUES.size())];
}

json otherNumber(const json& value, std::mt19937& random)
{
    const double number = value.get<double>();
    switch (pick(random, 6)) {
    case 0:
        return number + 1;
    case 1:
        return number - 1;
    case 2:
        return number * 2;
    case 3:
        return -number;
    case 4:
        return int64_t(random());
    default:
        return number * 1e10;
    }
}

std::string anyName(const Places& places, std::mt19937& random)
{
    return places.names.empty() ? "extras" : *std::next(places.names.begin(), long(pick(random, places.names.size())));
}

void edit(json& root, std::mt19937& random)
{
    Places places;
    places.collect(root);
    json& place = *places.values[pick(random, places.values.size())];
    const json other = *places.values[pick(random, places.values.size())];
    switch (pick(random, 6)) {
    case 0:
        if (place.is_object() && !place.empty())
            place.erase(std::next(place.begin(), long(pick(random, place.size()))));
        else if (place.is_array() && !place.empty())
            place.erase(place.begin() + long(pick(random, place.size())));
        break;
    case 1:
        place = other;
        break;
    case 2:
        if (place.is_object())
            place[anyName(places, random)] = pick(random, 2) ? other : awkward(random);
        else if (place.is_array())
            place.push_back(pick(random, 2) ? other : awkward(random));
        break;
    case 3:
        if (!place.is_structured())
            place = awkward(random);
        break;
    default:
        if (place.is_number())
            place = otherNumber(place, random);
    }
}

/// The edited text; empty when it is no JSON.
std::string editedJson(const std::string& text, std::mt19937& random)
{
    json root = json::parse(
        text,
        [](int depth, json::parse_event_t, json&) {
            if (depth > DEEPEST)
                throw std::runtime_error("too deep");
            return true;
        },
        false);
    if (root.is_discarded())
        return "";
    for (size_t edits = 1 + pick(random, 3); edits > 0; --edits)
        edit(root, random);
    return root.dump(-1, ' ', false, json::error_handler_t::replace);
}

Bytes changedBytes(Bytes bytes)
{
    const size_t size = bytes.size();
    bytes.resize(size + LARGEST_GROWTH);
    bytes.resize(LLVMFuzzerMutate(bytes.data(), size, bytes.size()));
    return bytes;
}

uint32_t little(const uint8_t* data)
{
    uint32_t word;
    std::memcpy(&word, data, sizeof word);
    return word;
}

void append(Bytes& bytes, std::initializer_list<uint32_t> words)
{
    for (const uint32_t word : words)
        for (int shift = 0; shift < 32; shift += 8)
            bytes.push_back(uint8_t(word >> shift));
}

/// A GLB with its JSON edited, or with its binary chunk changed.
Bytes mutatedGlb(const uint8_t* data, size_t size, std::mt19937& random)
{
    constexpr uint32_t MAGIC = 0x46546c67, JSON = 0x4e4f534a, BIN = 0x004e4942;
    if (size < 20 || little(data) != MAGIC || little(data + 12) > size - 20)
        return {};
    const size_t length = little(data + 12), rest = 20 + length;
    std::string text(data + 20, data + rest);
    Bytes binary;
    if (rest + 8 <= size)
        binary.assign(data + rest + 8, data + size);
    if (!binary.empty() && pick(random, 4) == 0)
        binary = changedBytes(std::move(binary));
    else
        text = editedJson(text, random);
    if (text.empty())
        return {};
    text.resize((text.size() + 3) / 4 * 4, ' ');
    binary.resize((binary.size() + 3) / 4 * 4);
    Bytes result;
    append(result, {MAGIC, 2, uint32_t(28 + text.size() + binary.size()), uint32_t(text.size()), JSON});
    result.insert(result.end(), text.begin(), text.end());
    append(result, {uint32_t(binary.size()), BIN});
    result.insert(result.end(), binary.begin(), binary.end());
    return result;
}

uint32_t big(const uint8_t* data)
{
    return uint32_t(data[0]) << 24 | uint32_t(data[1]) << 16 | uint32_t(data[2]) << 8 | data[3];
}

/// Changed bytes, then a checksum for each chunk that is still whole.
Bytes mutatedImage(const uint8_t* data, size_t size)
{
    Bytes bytes = changedBytes({data, data + size});
    for (size_t at = 8; at + 12 <= bytes.size() && big(bytes.data() + at) <= bytes.size() - at - 12;) {
        const uint32_t length = big(bytes.data() + at);
        const auto sum = uint32_t(crc32(0, bytes.data() + at + 4, length + 4));
        for (int i = 0; i < 4; ++i)
            bytes[at + 8 + length + size_t(i)] = uint8_t(sum >> (24 - 8 * i));
        at += 12 + length;
    }
    return bytes;
}

}  // namespace

Bytes mutated(Target target, const uint8_t* data, size_t size, std::mt19937& random)
{
    try {
        switch (target) {
        case Target::gltf:
            return mutatedGlb(data, size, random);
        case Target::graph: {
            const std::string text = editedJson({data, data + size}, random);
            return {text.begin(), text.end()};
        }
        case Target::image:
            return size > 1 && data[0] == 0x89 ? mutatedImage(data, size) : Bytes();
        default:
            return {};
        }
    } catch (const std::exception&) {
        return {};
    }
}

}  // namespace restirpg::fuzz
