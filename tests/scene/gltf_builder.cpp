#include "gltf_builder.h"

#include "core/log.h"
#include "scene/gltf.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STB_IMAGE_WRITE_STATIC
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image_write.h>
#pragma GCC diagnostic pop

#include <unistd.h>

namespace restirpg {

namespace {

void appendToVector(void* context, void* data, int size)
{
    auto& bytes = *static_cast<std::vector<uint8_t>*>(context);
    bytes.insert(bytes.end(), static_cast<uint8_t*>(data), static_cast<uint8_t*>(data) + size);
}

void appendWord(std::vector<uint8_t>& bytes, uint32_t word)
{
    for (int shift = 0; shift < 32; shift += 8)
        bytes.push_back(uint8_t(word >> shift));
}

std::vector<uint8_t> containerOf(const std::string& text, const std::vector<uint8_t>& binary)
{
    std::vector<uint8_t> bytes;
    const bool hasBinary = !binary.empty();
    appendWord(bytes, 0x46546c67);
    appendWord(bytes, 2);
    appendWord(bytes, uint32_t(12 + 8 + text.size() + (hasBinary ? 8 + binary.size() : 0)));
    appendWord(bytes, uint32_t(text.size()));
    appendWord(bytes, 0x4e4f534a);
    bytes.insert(bytes.end(), text.begin(), text.end());
    if (hasBinary) {
        appendWord(bytes, uint32_t(binary.size()));
        appendWord(bytes, 0x004e4942);
        bytes.insert(bytes.end(), binary.begin(), binary.end());
    }
    return bytes;
}

}  // namespace

GltfBuilder::GltfBuilder()
{
    json = {{"asset", {{"version", "2.0"}}}, {"scene", 0}, {"scenes", {{{"nodes", nlohmann::json::array()}}}}};
}

int GltfBuilder::append(nlohmann::json& array, const nlohmann::json& element)
{
    array.push_back(element);
    return int(array.size()) - 1;
}

int GltfBuilder::addView(const void* bytes, size_t size, size_t stride)
{
    nlohmann::json view = {{"buffer", 0}, {"byteOffset", binary_.size()}, {"byteLength", size}};
    if (stride)
        view["byteStride"] = stride;
    const auto* first = static_cast<const uint8_t*>(bytes);
    binary_.insert(binary_.end(), first, first + size);
    binary_.resize((binary_.size() + 3) / 4 * 4);
    return append(json["bufferViews"], view);
}

int GltfBuilder::addMesh(const nlohmann::json& primitives, const std::string& name)
{
    nlohmann::json mesh = {{"primitives", primitives.is_array() ? primitives : nlohmann::json::array({primitives})}};
    if (!name.empty())
        mesh["name"] = name;
    return append(json["meshes"], mesh);
}

int GltfBuilder::addNode(const nlohmann::json& node, bool root)
{
    const int index = append(json["nodes"], node);
    if (root)
        json["scenes"][0]["nodes"].push_back(index);
    return index;
}

int GltfBuilder::addTexture(const std::vector<uint8_t>& encoded, const nlohmann::json& sampler)
{
    const bool png = encoded.size() > 1 && encoded[1] == 'P';
    const int image = append(json["images"], {{"bufferView", addView(encoded.data(), encoded.size())},
                                              {"mimeType", png ? "image/png" : "image/jpeg"}});
    nlohmann::json texture = {{"source", image}};
    if (!sampler.is_null())
        texture["sampler"] = append(json["samplers"], sampler);
    return append(json["textures"], texture);
}

std::filesystem::path GltfBuilder::write(const std::filesystem::path& file) const
{
    auto root = json;
    const bool binary = file.extension() == ".glb";
    if (!binary_.empty() && !root.contains("buffers"))
        root["buffers"] = {{{"byteLength", binary_.size()}}};
    if (!binary && !binary_.empty() && !root["buffers"][0].contains("uri"))
        root["buffers"][0]["uri"] = "data:application/octet-stream;base64," + encodeBase64(binary_);
    auto text = root.dump();
    if (binary) {
        text.resize((text.size() + 3) / 4 * 4, ' ');
        writeBytes(file, containerOf(text, binary_));
    } else {
        writeBytes(file, {text.begin(), text.end()});
    }
    return file;
}

nlohmann::json addSquare(GltfBuilder& builder)
{
    const std::vector<float> positions = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    const std::vector<float> normals = {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1};
    const std::vector<float> uv = {0, 1, 1, 1, 1, 0, 0, 0};
    const std::vector<uint16_t> indices = {0, 1, 2, 0, 2, 3};
    return {{"attributes",
             {{"POSITION", builder.addAccessor(positions, FLOAT, "VEC3")},
              {"NORMAL", builder.addAccessor(normals, FLOAT, "VEC3")},
              {"TEXCOORD_0", builder.addAccessor(uv, FLOAT, "VEC2")}}},
            {"indices", builder.addAccessor(indices, UNSIGNED_SHORT, "SCALAR")}};
}

GltfBuilder squareScene()
{
    GltfBuilder builder;
    const auto square = addSquare(builder);
    builder.addNode({{"mesh", builder.addMesh(square, "Square")}});
    return builder;
}

std::filesystem::path scratch()
{
    struct Folder {
        std::filesystem::path path =
            std::filesystem::temp_directory_path() / ("restirpg_test_scene." + std::to_string(getpid()));
        Folder() { std::filesystem::create_directories(path); }
        ~Folder()
        {
            std::error_code ignored;
            std::filesystem::remove_all(path, ignored);
        }
    };
    static const Folder folder;
    return folder.path;
}

Scene load(const GltfBuilder& builder)
{
    return loadGltf(builder.write(scratch() / "scene.glb"));
}

glm::uvec3 fromEarliestVertex(glm::uvec3 triangle)
{
    while (triangle.x > triangle.y || triangle.x > triangle.z)
        triangle = {triangle.y, triangle.z, triangle.x};
    return triangle;
}

std::string errorOf(const GltfBuilder& builder)
{
    return errorOf([&] { load(builder); });
}

std::string errorOf(const std::function<void()>& run)
{
    try {
        run();
    } catch (const Error& error) {
        std::string message = error.what();
        EXPECT_EQ(message.find('\n'), message.npos) << message;
        EXPECT_GT(message.size(), 20u) << message;
        return message;
    }
    ADD_FAILURE() << "no Error was raised";
    return {};
}

bool wasWarned(const std::string& part)
{
    const auto said = saidWarnings();
    return std::any_of(said.begin(), said.end(), [&](const std::string& text) { return text.find(part) != text.npos; });
}

void expectNear(glm::vec3 a, glm::vec3 b, float tolerance)
{
    EXPECT_LT(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << " not " << b.x << " " << b.y << " " << b.z;
}

void writeBytes(const std::filesystem::path& file, const std::vector<uint8_t>& bytes)
{
    std::ofstream(file, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

std::vector<uint8_t> readBytes(const std::filesystem::path& file)
{
    std::ifstream stream(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
}

std::vector<uint8_t> encodePng(int width, int height, const std::vector<uint8_t>& rgba)
{
    std::vector<uint8_t> bytes;
    stbi_write_png_to_func(appendToVector, &bytes, width, height, 4, rgba.data(), width * 4);
    return bytes;
}

std::vector<uint8_t> encodeJpeg(int width, int height, const std::vector<uint8_t>& rgba)
{
    std::vector<uint8_t> bytes;
    stbi_write_jpg_to_func(appendToVector, &bytes, width, height, 4, rgba.data(), 90);
    return bytes;
}

std::string encodeBase64(const std::vector<uint8_t>& bytes)
{
    static const char* digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        const auto at = [&](size_t k) { return k < bytes.size() ? uint32_t(bytes[k]) : 0u; };
        const uint32_t group = at(i) << 16 | at(i + 1) << 8 | at(i + 2);
        for (size_t k = 0; k < 4; ++k)
            text += i + k <= bytes.size() ? digits[group >> (18 - 6 * k) & 63] : '=';
    }
    return text;
}

GltfBuilder geometryScene()
{
    GltfBuilder builder;
    builder.json["extensionsRequired"] = builder.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    const std::vector<int16_t> quantized = {0, 0, 0, 0, 32767, 0, 0, 0, 0, 32767, 0, 0, 32767, 32767, 0, 0};
    nlohmann::json strip = {{"mode", 5}};
    strip["attributes"]["POSITION"] =
        builder.addAccessorJson({{"bufferView", builder.addView(quantized.data(), quantized.size() * 2, 8)},
                                 {"componentType", SHORT},
                                 {"count", 4},
                                 {"type", "VEC3"},
                                 {"normalized", true}});
    strip["attributes"]["NORMAL"] = builder.addAccessorJson(
        {{"bufferView",
          builder.addView(std::vector<int8_t>{0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0}.data(), 16, 4)},
         {"componentType", BYTE},
         {"count", 4},
         {"type", "VEC3"},
         {"normalized", true}});
    strip["attributes"]["COLOR_0"] =
        builder.addAccessor(std::vector<uint8_t>{255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255},
                            UNSIGNED_BYTE, "VEC4", true);
    nlohmann::json fan = {{"mode", 6}};
    fan["attributes"]["POSITION"] =
        builder.addAccessor(std::vector<float>{0, 0, 1, 1, 0, 1, 1, 1, 1, 0, 1, 1}, FLOAT, "VEC3");
    // 0, 1, 2, 3: zeros, of which three are replaced by their own places.
    const int places = builder.addView(std::vector<uint8_t>{1, 2, 3}.data(), 3);
    fan["indices"] = builder.addAccessorJson({{"componentType", UNSIGNED_BYTE},
                                              {"count", 4},
                                              {"type", "SCALAR"},
                                              {"sparse",
                                               {{"count", 3},
                                                {"indices", {{"bufferView", places}, {"componentType", UNSIGNED_BYTE}}},
                                                {"values", {{"bufferView", places}}}}}});

    auto sparse = addSquare(builder);
    const int indices = builder.addView(std::vector<uint16_t>{1}.data(), 2);
    const int values = builder.addView(std::vector<float>{3, 0, 0}.data(), 12);
    auto& accessor = builder.json["accessors"][size_t(sparse["attributes"]["POSITION"])];
    accessor["sparse"] = {{"count", 1},
                          {"indices", {{"bufferView", indices}, {"componentType", UNSIGNED_SHORT}}},
                          {"values", {{"bufferView", values}}}};
    const nlohmann::json points = {{"mode", 0}, {"attributes", fan["attributes"]}};
    builder.addNode({{"mesh", builder.addMesh({strip, fan, sparse, points}, "Everything")}});
    builder.addNode({{"mesh", 0}, {"translation", {2, 0, 0}}, {"scale", {-1, 1, 1}}});
    return builder;
}

GltfBuilder texturedScene()
{
    GltfBuilder builder;
    std::vector<uint8_t> pixels(16 * 16 * 4);
    for (size_t i = 0; i < pixels.size(); ++i)
        pixels[i] = uint8_t(i * 37);
    const int png =
        builder.addTexture(encodePng(16, 16, pixels), {{"wrapS", 33071}, {"wrapT", 33648}, {"magFilter", 9728}});
    const int jpeg = builder.addTexture(encodeJpeg(16, 16, pixels));
    const nlohmann::json transform = {{"offset", {0.1, 0.2}}, {"scale", {2, 3}}, {"rotation", 0.5}, {"texCoord", 0}};
    const nlohmann::json moved = {{"index", png}, {"extensions", {{"KHR_texture_transform", transform}}}};
    builder.addMaterial(
        {{"name", "full"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.5, 0.6, 0.7, 0.8}},
           {"metallicFactor", 0.3},
           {"roughnessFactor", 0.4},
           {"baseColorTexture", moved},
           {"metallicRoughnessTexture", {{"index", jpeg}}}}},
         {"normalTexture", {{"index", png}, {"scale", 0.5}}},
         {"emissiveTexture", {{"index", jpeg}}},
         {"emissiveFactor", {1, 0.5, 0.25}},
         {"alphaMode", "MASK"},
         {"alphaCutoff", 0.4},
         {"doubleSided", true},
         {"extensions",
          {{"KHR_materials_emissive_strength", {{"emissiveStrength", 10}}},
           {"KHR_materials_ior", {{"ior", 1.4}}},
           {"KHR_materials_specular",
            {{"specularFactor", 0.5},
             {"specularColorFactor", {1, 0.9, 0.8}},
             {"specularTexture", {{"index", png}}},
             {"specularColorTexture", moved}}},
           {"KHR_materials_transmission", {{"transmissionFactor", 0.5}, {"transmissionTexture", moved}}},
           {"KHR_materials_volume",
            {{"thicknessFactor", 1}, {"attenuationDistance", 2}, {"attenuationColor", {0.5, 0.25, 1}}}}}}});
    builder.addMaterial({{"extensions", {{"KHR_materials_unlit", nlohmann::json::object()}}}});
    auto square = addSquare(builder), unlit = square;
    square["material"] = 0;
    unlit["material"] = 1;
    builder.addNode({{"mesh", builder.addMesh({square, unlit}, "Square")}});
    return builder;
}

GltfBuilder animatedScene()
{
    auto builder = squareScene();
    builder.json["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0}, {"zfar", 9}}}}};
    builder.json["extensions"]["KHR_lights_punctual"]["lights"] = {
        {{"type", "point"}, {"color", {1, 0.5, 0.25}}, {"intensity", 20}},
        {{"type", "spot"}, {"intensity", 5}, {"spot", {{"innerConeAngle", 0.1}, {"outerConeAngle", 0.4}}}},
        {{"type", "directional"}, {"intensity", 3}}};
    builder.json["asset"]["extras"]["restirpg"] = {
        {"environment", {0.1, 0.2, 0.3}}, {"strength", 2}, {"rotation", 90}, {"bounces", 6}};
    const auto light = [](int i) { return nlohmann::json{{"KHR_lights_punctual", {{"light", i}}}}; };
    const int spot = builder.addNode({{"extensions", light(1)}, {"rotation", {0, 1, 0, 0}}}, false);
    const int camera = builder.addNode({{"camera", 0}, {"translation", {0.5, 0.5, 4}}, {"name", "Camera"}}, false);
    builder.addNode({{"children", {spot, camera}}, {"extensions", light(0)}, {"translation", {1, 2, 3}}});
    builder.addNode(
        {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1}}, {"extensions", light(2)}, {"camera", 1}});
    const int times = builder.addAccessor(std::vector<float>{0, 1, 3}, FLOAT, "SCALAR");
    const int positions = builder.addAccessor(std::vector<float>{0, 0, 0, 1, 0, 0, 1, 2, 0}, FLOAT, "VEC3");
    const int turns =
        builder.addAccessor(std::vector<float>{0, 0, 0, 1, 0, 0, 0.70710678f, 0.70710678f, 0, 0, 1, 0}, FLOAT, "VEC4");
    std::vector<float> spline(27, 0.0f);
    spline[3] = spline[12] = spline[21] = 1;
    spline[4] = spline[13] = spline[22] = 1;
    spline[5] = spline[14] = 1;
    spline[23] = 4;
    const int scales = builder.addAccessor(spline, FLOAT, "VEC3");
    builder.json["animations"] = {{{"name", "Move"},
                                   {"samplers",
                                    {{{"input", times}, {"output", positions}, {"interpolation", "STEP"}},
                                     {{"input", times}, {"output", turns}},
                                     {{"input", times}, {"output", scales}, {"interpolation", "CUBICSPLINE"}}}},
                                   {"channels",
                                    {{{"sampler", 0}, {"target", {{"node", 0}, {"path", "translation"}}}},
                                     {{"sampler", 1}, {"target", {{"node", 0}, {"path", "rotation"}}}},
                                     {{"sampler", 2}, {"target", {{"node", 0}, {"path", "scale"}}}}}}}};
    return builder;
}

}  // namespace restirpg
