#include "core/error.h"
#include "image/image.h"
#include "scene/gltf.h"
#include "scene/gltf_file.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace restirpg {

namespace {

/// "r,g,b" as three numbers; nothing when the text is anything else.
std::optional<glm::vec3> parseRadiance(const std::string& text)
{
    std::istringstream stream(text);
    glm::vec3 radiance;
    char comma1 = 0, comma2 = 0, rest = 0;
    stream >> radiance.x >> comma1 >> radiance.y >> comma2 >> radiance.z;
    if (!stream || comma1 != ',' || comma2 != ',' || stream >> rest)
        return {};
    return radiance;
}

Texture toTexture(const Image& image, const std::string& source)
{
    Texture texture;
    texture.name = std::filesystem::path(source).filename().string();
    texture.width = image.width;
    texture.height = image.height;
    texture.wrapV = Texture::Wrap::clampToEdge;
    texture.floats.resize(size_t(image.width) * image.height * 4, 1.0f);
    for (size_t i = 0; i < size_t(image.width) * image.height; ++i)
        std::copy_n(image.data.begin() + ptrdiff_t(3 * i), 3, texture.floats.begin() + ptrdiff_t(4 * i));
    return texture;
}

}  // namespace

Environment loadEnvironment(const std::string& source)
{
    Environment environment;
    if (const auto radiance = parseRadiance(source)) {
        const float sum = radiance->x + radiance->y + radiance->z;
        if (!std::isfinite(sum) || glm::any(glm::lessThan(*radiance, glm::vec3(0))))
            fail("environment '{}': radiances must be finite and at least 0; give r,g,b in W/sr/m^2", source);
        environment.radiance = *radiance;
        return environment;
    }
    auto extension = std::filesystem::path(source).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (extension != ".exr" && extension != ".hdr")
        fail("environment '{}': is neither an .exr, nor an .hdr, nor three numbers r,g,b; give one of these", source);
    environment.texture = toTexture(readRadiance(source), source);
    environment.radiance = glm::vec3(1);
    return environment;
}

void replaceEnvironment(Scene& scene, const std::string& source)
{
    scene.environment = loadEnvironment(source);
    const glm::vec3 radiance = scene.environment->radiance;
    scene.givenEnvironment = {fmt::format("{},{},{}", radiance.x, radiance.y, radiance.z), ""};
    if (!scene.environment->texture)
        return;
    const auto bytes = gltf::readBytes(source);
    scene.givenEnvironment = {scene.environment->texture->name,
                              fmt::format("{:016x}", hashBytes(bytes.data(), bytes.size()))};
    scene.files.emplace_back(source);
}

}  // namespace restirpg
