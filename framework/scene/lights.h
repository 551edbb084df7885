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

/// The scene's lights as kernels see them, at the given node poses. A light keeps its index while nodes move:
/// reservoirs refer to it.
struct LightTable {
    std::vector<Light> lights;
    std::vector<uint32_t> lightOfTriangle;  ///< see Instance::lightMap
    std::vector<uint32_t> lightMapOfInstance;  ///< base into lightOfTriangle per instance, INVALID_INDEX: none
    std::vector<uint32_t> punctualLights;  ///< index into lights of each of the scene's, INVALID_INDEX: dark
    std::vector<ImportanceCell> emissionCells;  ///< see Light::cells
    std::vector<ImportanceCell> environmentCells;  ///< one a texel, row by row; empty: constant or none
    uint32_t environmentLight = INVALID_INDEX;
    bool lit = false;  ///< some light has power in this pose, so that one can be selected

    // What the host makes the powers from.
    /// Power of a punctual light, W; else power over area or over the scene's disk, W/m^2
    std::vector<double> strengths;
    std::vector<double> powers;  ///< W, as the alias table has them
    /// M^T M of the linear part that the powers are of: what lengths depend on
    std::vector<glm::mat3> metricOfInstance;
};

/// Build the table. Weights are powers in watts (luminance): pi A L for a triangle (twice for a double-sided one; a
/// textured one by its mean over the triangle), 4 pi I for a point, 2 pi (1 - cos outer) I for a spot, pi r^2 E for
/// a directional light, pi r^2 * int L for the environment. What is dark in every pose is left out; a triangle without
/// area is not, because it may grow.
LightTable buildLightTable(const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius);

/// Bring the table to another pose. Places of punctual lights always follow; areas are measured again where an instance
/// has changed its shape, and the alias table is made again where a power has changed.
void moveLights(LightTable& table, const Scene& scene, const std::vector<glm::mat4>& pose, float sceneRadius);

}  // namespace restirpg
