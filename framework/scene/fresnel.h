// Dielectric Fresnel reflectance on the host.
#pragma once

namespace restirpg {

/// Unpolarised reflectance of a smooth dielectric, 1 under total internal reflection; `cosine` of the incident
/// direction in [0, 1], `ior`: index behind the surface over the one before it.
double fresnelDielectric(double cosine, double ior);

/// Cosine-weighted mean over the hemisphere of (F(cos) - F0) / (1 - F0), i.e. 2 int_0^1 (F(c) - F0) / (1 - F0) c dc:
/// what Schlick's (1 - cos)^5 averages 1/21 for. That is taken for ior 0, total reflection. Material::coatAverage.
float fresnelCoatAverage(float ior);

}  // namespace restirpg
