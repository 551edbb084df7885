// What GGX returns by single scattering, tabulated: the basis of energy compensation (shaders/bsdf/energy.glsl).
#pragma once

#include "shaders/scene/scene_types.h"

#include <vector>

namespace restirpg {

/// Integrals over the lobes of a white interface of this index (0: infinite), by quadrature over visible normals.
/// ENERGY_TABLE entries: two sides (seen from outside, from inside), each ENERGY_ROWS roughnesses from 0 to 1, each
/// ENERGY_COLUMNS cosines (square roots evenly spaced from 0 to 1) and then the row's cosine-weighted mean. An entry
/// holds, with the Fresnel term split as coat_fresnel does, F = coat0 + (coat90 - coat0) position:
///   x  reflected, F = 1;  y  reflected, F = position;  z  refracted, 1 - F = 1;  w  refracted, 1 - F = position
std::vector<glm::vec4> energyTable(float ior);

}  // namespace restirpg
