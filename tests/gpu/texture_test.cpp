// Texture lookups of kernels against the host's, which follow the Vulkan specification in doubles.
#include "../support/sample_texture.h"
#include "gpu_test.h"
#include "light_scenes.h"
#include "texture_case.h"

#include "scene/srgb.h"

#include <cmath>
#include <random>

namespace restirpg::test {
namespace {

std::vector<glm::vec4> lookUp(const UploadedScene& scene, uint32_t texture, const std::vector<glm::vec2>& places)
{
    const Buffer inputs = device().createBuffer(places, "places");
    const Buffer results = device().createBuffer(places.size() * sizeof(glm::vec4), "values");
    TextureCase test{};
    test.frame = scene.frame.address();
    test.places = inputs.address();
    test.values = results.address();
    test.texture = texture;
    test.count = uint32_t(places.size());
    run("texture_values", test, uint32_t((places.size() + 63) / 64 * 64), &scene.gpu.bindings());
    return device().download<glm::vec4>(results, places.size());
}

/// Every 8-bit level in each channel, at most one of them a texel.
Texture levels(bool srgb)
{
    Texture texture;
    texture.width = 256;
    texture.height = 3;
    texture.srgb = srgb;
    for (uint32_t y = 0; y < texture.height; ++y)
        for (uint32_t x = 0; x < texture.width; ++x)
            for (uint32_t c = 0; c < 4; ++c)
                texture.bytes.push_back(uint8_t(c == y || c == 3 ? x : 0));
    return texture;
}

/// Noise of bytes, or of floats of a wide range.
Texture noise(uint32_t width, uint32_t height, bool floats)
{
    std::mt19937 random(width + height);
    Texture texture;
    texture.width = width;
    texture.height = height;
    for (uint32_t i = 0; i < 4 * width * height; ++i) {
        if (floats)
            texture.floats.push_back(std::exp(std::uniform_real_distribution<float>(-5, 5)(random)));
        else
            texture.bytes.push_back(uint8_t(random()));
    }
    return texture;
}

TEST(Textures, EveryLevelIsDecodedExactly)
{
    Scene source = darkScene();
    source.textures = {levels(false), levels(true)};
    const UploadedScene scene(source);
    std::vector<glm::vec2> places;
    for (int y = 0; y < 3; ++y)
        for (int x = 0; x < 256; ++x)
            places.emplace_back((float(x) + 0.5f) / 256, (float(y) + 0.5f) / 3);
    const auto linear = lookUp(scene, 0, places), srgb = lookUp(scene, 1, places);
    for (size_t i = 0; i < places.size(); ++i) {
        const double level = double(i % 256) / 255, decoded = srgbToLinear(float(level));
        const int channel = int(i / 256);
        // Half floats would be within 5e-4 of the value, lavapipe's sampler within 2.5%.
        ASSERT_NEAR(linear[i][channel], level, 1e-6 * level) << i % 256;
        ASSERT_NEAR(srgb[i][channel], decoded, 3e-6 * decoded) << i % 256;
        ASSERT_NEAR(srgb[i].a, level, 1e-6 * level) << "alpha is not encoded";
        ASSERT_EQ(srgb[i][(channel + 1) % 3], 0);
    }
}

/// H0: none; lookups are deterministic. Places on both sides of the texture, on its edges and far away.
TEST(Textures, LookupsWrapAndFilterAsSpecified)
{
    using Wrap = Texture::Wrap;
    using Filter = Texture::Filter;
    Scene source = darkScene();
    for (const auto& [wrapU, wrapV] : {std::pair{Wrap::repeat, Wrap::mirroredRepeat},
                                       {Wrap::mirroredRepeat, Wrap::clampToEdge},
                                       {Wrap::clampToEdge, Wrap::repeat}})
        for (const Filter filter : {Filter::linear, Filter::nearest})
            for (const auto& [width, height] : {std::pair{1u, 1u}, {5u, 3u}, {64u, 1u}, {17u, 32u}})
                for (const bool floats : {false, true}) {
                    Texture texture = noise(width, height, floats);
                    texture.wrapU = wrapU;
                    texture.wrapV = wrapV;
                    texture.filter = filter;
                    texture.srgb = !floats;
                    source.textures.push_back(texture);
                }
    const UploadedScene scene(source);
    std::mt19937 random(5);
    std::uniform_real_distribution<float> near(-2.5f, 3.5f);
    std::vector<glm::vec2> places = {{0, 0}, {1, 1}, {-1, 2}, {0.5f, 0.5f}, {-1e-9f, -1e-9f}, {1e9f, -1e9f}};
    while (places.size() < 256)
        places.emplace_back(near(random), near(random));
    for (uint32_t t = 0; t < source.textures.size(); ++t) {
        const Texture& texture = source.textures[t];
        const auto values = lookUp(scene, t, places);
        float largest = 0;
        for (const float value : texture.floats.empty() ? std::vector<float>{1} : texture.floats)
            largest = std::max(largest, value);
        for (size_t i = 0; i < places.size(); ++i) {
            const glm::vec2 texel = glm::vec2(places[i]) * glm::vec2(texture.width, texture.height);
            const glm::vec2 fromEdge = glm::abs(texel - glm::round(texel));
            if (texture.filter == Filter::nearest && std::min(fromEdge.x, fromEdge.y) < 1e-4f)
                continue;  // on the edge of two texels rounding decides
            // Coordinates are floats: at 3 periods of 64 texels a weight is good to 2e-5.
            ASSERT_LT(glm::distance(values[i], sampleTexture(texture, places[i])), 3e-5f * largest)
                << "texture " << t << " at " << places[i].x << ", " << places[i].y;
        }
    }
}

/// Cutoffs of alpha masks and the limits of roughness are compared with what the filter returns.
TEST(Textures, EqualTexelsGiveExactlyTheirValue)
{
    Scene source = darkScene();
    source.textures = {noise(64, 64, false), noise(64, 64, true)};
    for (size_t i = 0; i < source.textures[0].bytes.size(); i += 4) {
        source.textures[0].bytes[i + 1] = 51;
        source.textures[0].bytes[i + 3] = 255;
        source.textures[1].floats[i + 2] = 0.7f;
    }
    const UploadedScene scene(source);
    std::mt19937 random(6);
    std::uniform_real_distribution<float> anywhere(-1, 2);
    std::vector<glm::vec2> places(4096);
    for (glm::vec2& place : places)
        place = {anywhere(random), anywhere(random)};
    const auto bytes = lookUp(scene, 0, places), floats = lookUp(scene, 1, places);
    for (size_t i = 0; i < places.size(); ++i) {
        ASSERT_EQ(bytes[i].g, bytes[0].g) << places[i].x << ", " << places[i].y;
        ASSERT_EQ(bytes[i].a, 1) << places[i].x << ", " << places[i].y;
        ASSERT_EQ(floats[i].b, 0.7f) << places[i].x << ", " << places[i].y;
    }
}

/// 8 x 8 texels of one value, which fill their memory without a gap.
Texture flat(float value)
{
    Texture texture;
    texture.width = texture.height = 8;
    texture.floats.assign(4 * 64, value);
    return texture;
}

/// A texture of values within [2, 3] lies between two of another value: a read outside of it shows. H0: none.
TEST(Textures, NoCoordinateReadsOutside)
{
    using Wrap = Texture::Wrap;
    using Filter = Texture::Filter;
    Scene source = darkScene();
    std::mt19937 random(7);
    std::uniform_real_distribution<float> values(2.1f, 2.9f);
    source.textures = {flat(100)};
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirroredRepeat, Wrap::clampToEdge})
        for (const Filter filter : {Filter::linear, Filter::nearest}) {
            Texture texture = flat(0);
            for (float& value : texture.floats)
                value = values(random);
            texture.wrapU = texture.wrapV = wrap;
            texture.filter = filter;
            source.textures.push_back(texture);
            source.textures.push_back(flat(100));
        }
    const UploadedScene scene(source);
    const float below = std::nextafter(1.0f, 0.0f), above = std::nextafter(1.0f, 2.0f);
    std::vector<glm::vec2> places = {{NAN, 0}, {0, INFINITY}, {-INFINITY, NAN}, {3e38f, -3e38f}};
    for (const float u :
         {0.0f, -0.0f, -1e-45f, -1e-9f, 0.01f, 0.99f, below, 1.0f, above, -1.0f, -below, 2.0f, 1e9f, -1e9f})
        for (const float v : {0.5f, -1e-9f, 0.0f, below, 1.0f, 1.99f, -1e9f})
            places.insert(places.end(), {{u, v}, {v, u}});
    for (uint32_t t = 1; t < source.textures.size(); t += 2) {
        const auto seen = lookUp(scene, t, places);
        for (size_t i = 0; i < places.size(); ++i)
            for (int c = 0; c < 4; ++c) {
                const bool number = std::isfinite(places[i].x) && std::isfinite(places[i].y);
                EXPECT_TRUE((seen[i][c] >= 2 && seen[i][c] <= 3) || (!number && std::isnan(seen[i][c])))
                    << seen[i][c] << " of texture " << t << " at " << places[i].x << ", " << places[i].y;
            }
    }
}

}  // namespace
}  // namespace restirpg::test
