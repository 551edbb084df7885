// The materials and directions of the BSDF tests.
#pragma once

#include "bsdf_case.h"

#include <string>
#include <vector>

namespace restirpg::test {

// framework/shaders/bsdf/bsdf.glsl
constexpr uint32_t LOBE_DIFFUSE = 1;
constexpr uint32_t LOBE_REFLECT = 2;
constexpr uint32_t LOBE_TRANSMIT = 4;
constexpr uint32_t LOBE_ALL = 7;
constexpr double DELTA_ROUGHNESS = 0.03;

/// Reflectance of a dielectric interface, in double and by amplitudes: an independent form of the shader's.
double dielectricFresnel(double cosine, double eta);

/// Material::coatAverage by quadrature.
double coatAverage(double ior);

struct NamedMaterial {
    std::string name;
    BsdfCase material;
    std::vector<uint32_t> lobes;  ///< present ones
};

/// Plastics, metals, mixtures, glass from both sides, thin sheets; smooth, sharp and rough.
const std::vector<NamedMaterial>& materials();

/// One material by name.
const BsdfCase& material(const std::string& name);

/// From head-on to grazing, at several azimuths.
const std::vector<glm::vec3>& directions();

}  // namespace restirpg::test
