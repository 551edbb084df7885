// How the light of textured emitters is spread over their triangles.
#pragma once

#include "scene/scene.h"

#include <map>
#include <vector>

namespace restirpg {

/// Rec.709 luminance.
inline double luminance(const glm::dvec3& rgb)
{
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}

/// Equal parts of a triangle, by their emission. Part y * side + x is shaders/scene/lights.glsl's emission_part.
struct EmissionParts {
    uint32_t side;
    std::vector<double> luminances;  ///< side^2 of them
};

/// What the scene's triangles emit, in the order of Scene::triangles.
struct Emission {
    std::vector<double> mean;  ///< luminance, W/sr/m^2; 0 where nothing of the triangle emits, and there only
    std::map<uint32_t, EmissionParts> parts;  ///< of triangles that are much brighter in some places than in others
};

/// A textured triangle is cut into parts. Each is weighed by the mean of all texels that a lookup inside of it can
/// read, so that none is 0 where the texture is not; their mean is the triangle's.
Emission measureEmission(const Scene& scene);

}  // namespace restirpg
