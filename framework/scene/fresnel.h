// Dielectric Fresnel reflectance on the host.
#pragma once

namespace restirpg {

/// Unpolarised reflectance of a smooth dielectric for light from outside; `cosine` in [0, 1], `ior` >= 1 inside over
/// outside.
float fresnelDielectric(float cosine, float ior);

/// Cosine-weighted mean over the hemisphere of (F(cos) - F0) / (1 - F0), i.e. 2 int_0^1 (F(c) - F0) / (1 - F0) c dc:
/// what Schlick's (1 - cos)^5 averages 1/21 for. Material::coatAverage.
float fresnelCoatAverage(float ior);

}  // namespace restirpg
