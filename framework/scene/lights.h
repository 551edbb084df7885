// Power-weighted light selection: Walker's alias method over emissive triangles, punctual lights and the environment.
#pragma once

#include "scene/scene.h"

#include <span>

namespace restirpg {

/// One column of an alias table: keep the column where the fraction is below the threshold, else take the alias.
struct AliasColumn {
    float threshold;
    uint32_t alias;
};

/// Walker/Vose alias table of non-negative weights (any scale, at least one positive). `pmf` receives the normalised
/// probabilities exactly as the table realises them in float.
std::vector<AliasColumn> buildAliasTable(std::span<const double> weights, std::vector<float>& pmf);

/// The scene's lights as kernels see them, at the given node poses.
struct LightTable {
    std::vector<Light> lights;
    std::vector<uint32_t> lightOfTriangle;  ///< see Instance::lightMap
    std::vector<uint32_t> lightMapOfInstance;  ///< base into lightOfTriangle per instance, INVALID_INDEX: none
    std::vector<uint32_t> punctualLights;  ///< index into lights of each of the scene's, INVALID_INDEX: without power
    std::vector<EnvironmentCell> environmentCells;  ///< one a texel, row by row, pdf of mean 1; empty: constant or none
    uint32_t environmentLight = INVALID_INDEX;
};

/// Build the table. Weights are powers in watts (luminance): pi A L for a triangle (twice for a double-sided one; a
/// textured one by its mean over the triangle), 4 pi I for a point, 2 pi (1 - cos outer) I for a spot, pi r^2 E for
/// a directional light, pi r^2 * int L for the environment. What has no power is left out; `lights` is empty when
/// nothing has any.
LightTable buildLightTable(const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius);

/// Refresh the world-space fields of punctual lights after nodes moved. Probabilities stay as they are.
void moveLights(LightTable& table, const Scene& scene, const std::vector<glm::mat4>& pose);

}  // namespace restirpg
