// What kernels read of a texture (shaders/scene/texture.glsl), computed on the host.
#pragma once

#include "scene/scene.h"

#include <algorithm>
#include <cmath>

namespace restirpg {

/// Texel index along one axis after wrapping [Vulkan 1.3, 16.6]. Doubles: a coordinate may lie beyond any integer type.
inline uint32_t wrapTexel(double texel, uint32_t size, Texture::Wrap wrap)
{
    const double n = size;
    switch (wrap) {
    case Texture::Wrap::clampToEdge:
        break;
    case Texture::Wrap::repeat:
        texel -= n * std::floor(texel / n);
        break;
    case Texture::Wrap::mirroredRepeat:
        texel -= 2 * n * std::floor(texel / (2 * n));
        texel = texel < n ? texel : 2 * n - 1 - texel;
    }
    return uint32_t(std::clamp(texel, 0.0, n - 1));
}

/// Linear RGBA at (u, v), with the texture's own wrap and filter: the kernels' value but for rounding.
inline glm::vec4 sampleTexture(const Texture& texture, glm::vec2 uv)
{
    const double x = double(uv.x) * texture.width, y = double(uv.y) * texture.height;
    const auto wrapped = [&](double i, double j) {
        return texture.texel(wrapTexel(i, texture.width, texture.wrapU), wrapTexel(j, texture.height, texture.wrapV));
    };
    if (texture.filter == Texture::Filter::nearest)
        return wrapped(std::floor(x), std::floor(y));
    const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
    const float fx = float(x - 0.5 - left), fy = float(y - 0.5 - top);
    return glm::mix(glm::mix(wrapped(left, top), wrapped(left + 1, top), fx),
                    glm::mix(wrapped(left, top + 1), wrapped(left + 1, top + 1), fx), fy);
}

}  // namespace restirpg
