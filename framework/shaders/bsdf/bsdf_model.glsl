// The one BSDF: glTF metallic-roughness with KHR_materials_{specular, ior, transmission, volume}, as a sum of three
// lobes that can be addressed one by one. Local frame: z is the shading normal on wo's side; wo and wi point away from
// the surface; wo.z > 0.
//
//   diffuse   (1 - m)(1 - t) base / pi * (1 - Fc(wo)) (1 - Fc(wi)) / (1 - Fc_avg),  Fc the coat's share (coat_cosine)
//   reflect   F D G / (4 cos_o cos_i),  F = mix(dielectric, Schlick(base), m)
//   transmit  (1 - m) t base (1 - max F) times Walter et al. 2007's GGX BTDF (solid), or a mirrored reflection (thin)
//
// Two deliberate deviations from glTF's sample BRDF. Diffuse: under glTF's (1 - F(wo.h)) a white surface reaches an
// albedo of 1.9 at grazing; the form above (Shirley et al. 1997, Kelemen & Szirmay-Kalos 2001) is reciprocal, conserves
// energy, and under a smooth coat a white base reflects exactly 1. Thin transmission: a pane has two faces, and the
// light between them sums to a reflectance 2F / (1 + F), as in Mitsuba's `thindielectric`; glTF counts one face. Single
// scattering only: rough surfaces lose energy (benchmarks/results/ggx_energy_loss), reciprocity is exact. With
// RESTIRPG_ENERGY_COMPENSATION what they lose comes back (multiple_scattering.glsl). The diffuse part of a
// half-transparent solid is its outer paint: from inside it absorbs.
#ifndef RESTIRPG_BSDF_MODEL_GLSL
#define RESTIRPG_BSDF_MODEL_GLSL

#include "fresnel.glsl"
#include "prelude.glsl"

#ifndef RESTIRPG_ENERGY_COMPENSATION
#define RESTIRPG_ENERGY_COMPENSATION 0
#endif
#if RESTIRPG_ENERGY_COMPENSATION
#include "energy.glsl"
#endif

const uint LOBE_DIFFUSE = 1u;
const uint LOBE_REFLECT = 2u;
const uint LOBE_TRANSMIT = 4u;
const uint LOBE_ALL = 7u;

/// Linear roughness below which REFLECT and TRANSMIT are exact delta lobes (Mitsuba's reference scenes switch at the
/// same place).
const float DELTA_ROUGHNESS = 0.03;
/// Linear roughness up to which they are "sharp": their own label, never guided, never reconnected [shaders/README: Labels].
const float SHARP_ROUGHNESS = 0.2;
/// A rough lobe that can be non-zero is chosen at least this often, so that no weight grows without bound [shaders/README: Labels].
const float MIN_LOBE_PROBABILITY = 0.05;
/// Below this |ior - 1| a surface is invisible: the half vector of refraction has no digits left.
const float INDEX_MATCHED = 1e-3;

/// The evaluated material at a point: glTF's values, textures applied.
struct BsdfParameters {
    vec3 baseColor;
    float metallic;
    float roughness;  ///< linear; alpha = roughness^2
    float specular;
    vec3 specularColor;
    float transmission;
    float ior;  ///< 0: glTF's "infinite", F0 = 1
    float coatAverage;  ///< Material::coatAverage
    bool solid;  ///< MATERIAL_SOLID: refracts, where `transmission` is not 0; else a thin sheet
    bool entering;  ///< wo is on the outside; matters for solids only
#if RESTIRPG_ENERGY_COMPENSATION
    Address energyTable;  ///< of this ior
#endif
};

#if RESTIRPG_ENERGY_COMPENSATION
/// Coefficients k / <L> of the multiple-scattering lobe f = k L(wo) L(wi) / (pi <L>) (multiple_scattering.glsl), where L(w)
/// is the share that single scattering loses and <L> its mean. All 0 if alpha is 0.
struct MultipleScattering {
    Address table;
    EnergyRows near;  ///< rows of the table on wo's side
    EnergyRows far;  ///< on the other side
    vec3 metal;  ///< the metal's share, with the losses of a rough mirror; both directions on wo's side
    vec3 reflected;  ///< the transmitting dielectric, with its own losses; both directions on wo's side
    vec3 across;  ///< the same, wi on the other side
};
#endif

struct Bsdf {
    vec3 diffuse;  ///< (1 - m)(1 - t) base / (1 - Fc_avg); 0 inside a solid
    vec3 metal;  ///< Schlick's F0
    vec3 transmittance;  ///< (1 - m) t base
    vec3 coat0;  ///< dielectric F at normal incidence, KHR_materials_specular applied
    float coat90;  ///< and at grazing
    float f0;  ///< of the bare interface
    float metallic;
    float pane;  ///< share of the dielectric that is a thin pane
    float eta;  ///< n(far side) / n(wo's side); 0: infinite
    float alpha;  ///< of GGX; 0 where the lobes are deltas
    float roughness;  ///< linear
    uint lobes;  ///< LOBE_* that can be non-zero
    bool solid;
#if RESTIRPG_ENERGY_COMPENSATION
    MultipleScattering multiple;
#endif
};

// ---- Fresnel terms ----

/// How far from F0 to F90 the dielectric interface is at this cosine: exact Fresnel, normalised.
float coat_position(Bsdf b, float cosine)
{
    float exact = (fresnel_dielectric(cosine, b.eta) - b.f0) / max(1.0 - b.f0, 1e-6);
    return b.eta == 0.0 ? schlick_weight(cosine) : exact;
}

/// Total internal reflection is total whatever the specular factor: light that it took off would be neither reflected nor refracted. Of rough
/// solids with compensation that light comes back by the tables.
bool reflects_totally(Bsdf b, float cosine)
{
    bool returned = RESTIRPG_ENERGY_COMPENSATION != 0 && b.alpha > 0.0;
    return b.solid && b.eta < 1.0 && !returned && fresnel_dielectric(cosine, b.eta) >= 1.0;
}

/// Reflectance of one dielectric interface.
vec3 coat_fresnel(Bsdf b, float cosine)
{
    if (reflects_totally(b, cosine))
        return vec3(1.0);
    return clamp(mix(b.coat0, vec3(b.coat90), coat_position(b, cosine)), 0.0, 1.0);
}

/// The largest channel. What lies below the coat gets what the coat leaves of it, in every channel: by each channel's
/// own rest it would be tinted by the complement of the coat's colour [KHR_materials_specular].
float largest(vec3 color)
{
    return max(color.r, max(color.g, color.b));
}

/// What the coat takes of the light towards what lies below it.
float coat_share(Bsdf b, float cosine)
{
    return largest(coat_fresnel(b, cosine));
}

/// Both faces of a thin pane, all orders of reflection between them.
float pane_fresnel(float f)
{
    return 2.0 * f / (1.0 + f);
}

vec3 pane_fresnel(vec3 f)
{
    return 2.0 * f / (1.0 + f);
}

/// What the REFLECT lobe multiplies D and G with.
vec3 reflect_fresnel(Bsdf b, float cosine)
{
    vec3 coat = coat_fresnel(b, cosine);
    return mix(mix(coat, pane_fresnel(coat), b.pane), fresnel_schlick(b.metal, cosine), b.metallic);
}

/// What the TRANSMIT lobe multiplies its shape with. 0 under total internal reflection.
vec3 transmit_fresnel(Bsdf b, float cosine)
{
    float coat = coat_share(b, cosine);
    vec3 refracted = fresnel_dielectric(cosine, b.eta) < 1.0 ? b.transmittance * (1.0 - coat) : vec3(0.0);
    return b.solid ? refracted : b.transmittance * (1.0 - pane_fresnel(coat));
}

/// The cosine at which a smooth interface reflects what the rough one seen at `cosine` does: about the mean of wo.h
/// over the facets that wo sees; the identity for alpha = 0. Fitted to quadratures of the GGX lobe for ior 1.2 to 2.4,
/// on which it hardly depends, from the safe side: the reflectance is never 0.005 too small, and 0.03 too large at most
/// for cosines above 0.15. With the macroscopic cosine instead, rough paint would turn black at grazing: the coat would
/// take there what its facets do not reflect.
float coat_cosine(float cosine, float alpha)
{
    float grazing = 0.511 * alpha / (0.228 + alpha);
    float normal = 1.0 - 0.293 * alpha / (0.816 + alpha);
    float linear = 1.222 * alpha * alpha;
    float g2 = grazing * grazing;
    return sqrt(g2 + cosine * (linear + cosine * (normal * normal - g2 - linear)));
}

#if RESTIRPG_ENERGY_COMPENSATION
#include "multiple_scattering.glsl"
#endif

/// Light that passes the coat towards the diffuse base, for one direction.
float coat_passage(Bsdf b, float cosine)
{
#if RESTIRPG_ENERGY_COMPENSATION
    if (b.alpha > 0.0)
        return 1.0 - coat_energy(b, energy_returned(b.multiple.table, b.multiple.near, cosine));
#endif
    return 1.0 - coat_share(b, coat_cosine(cosine, b.alpha));
}

// ---- Construction and classes of lobes ----

/// Cosine-weighted mean of coat_position over the hemisphere outside. The factor of alpha bounds the fall of the mean
/// under roughness from below (for ior 1.2 to 3), so that the diffuse lobe never gains energy.
float coat_average(BsdfParameters p, float alpha)
{
    return p.coatAverage / (1.0 + alpha * (2.6 + 12.4 * alpha));
}

Bsdf make_bsdf(BsdfParameters p)
{
    Bsdf b;
    float ior = abs(p.ior - 1.0) < INDEX_MATCHED ? 1.0 : p.ior;
    b.solid = p.solid && ior > 0.0;
    bool inside = b.solid && !p.entering;
    b.eta = inside ? 1.0 / ior : ior;
    b.f0 = fresnel_f0(ior);
    b.coat0 = p.specular * min(b.f0 * p.specularColor, vec3(1.0));
    b.coat90 = ior == 1.0 ? 0.0 : p.specular;
    b.metal = p.baseColor;
    b.metallic = p.metallic;
    b.pane = b.solid ? 0.0 : p.transmission;
    b.roughness = p.roughness;
    b.alpha = p.roughness < DELTA_ROUGHNESS ? 0.0 : p.roughness * p.roughness;

    float average = mix(largest(b.coat0), b.coat90, coat_average(p, b.alpha));
#if RESTIRPG_ENERGY_COMPENSATION
    b.multiple = multiple_scattering(b, p, inside);
    if (b.alpha > 0.0)
        average = coat_energy(b, energy_mean(b.multiple.table, b.multiple.near));
#endif
    vec3 base = (1.0 - p.metallic) * p.baseColor;
    b.diffuse = inside ? vec3(0.0) : (1.0 - p.transmission) * base / max(1.0 - average, 1e-4);
    b.transmittance = p.transmission * base;

    b.lobes = 0u;
    if (any(greaterThan(b.diffuse, vec3(0.0))))
        b.lobes |= LOBE_DIFFUSE;
    if (p.metallic > 0.0 || b.coat90 > 0.0 || (b.solid && b.eta < 1.0))
        b.lobes |= LOBE_REFLECT;
    if (any(greaterThan(b.transmittance, vec3(0.0))))
        b.lobes |= LOBE_TRANSMIT;
#if RESTIRPG_ENERGY_COMPENSATION
    if (any(greaterThan(b.multiple.metal + b.multiple.reflected + b.multiple.across, vec3(0.0))))
        b.lobes |= LOBE_DIFFUSE;
#endif
    return b;
}

/// Is this lobe an exact delta? Refraction between equal indices is one at any roughness.
bool bsdf_is_delta(Bsdf b, uint lobe)
{
    bool index_matched = lobe == LOBE_TRANSMIT && b.solid && b.eta == 1.0;
    return lobe != LOBE_DIFFUSE && (b.roughness < DELTA_ROUGHNESS || index_matched);
}

/// Is this lobe its own label? Every delta lobe is.
bool bsdf_is_sharp(Bsdf b, uint lobe)
{
    return lobe != LOBE_DIFFUSE && (b.roughness <= SHARP_ROUGHNESS || bsdf_is_delta(b, lobe));
}

/// The present lobes of `mask` that are not deltas.
uint bsdf_rough_lobes(Bsdf b, uint mask)
{
    uint lobes = b.lobes & mask;
    lobes &= bsdf_is_delta(b, LOBE_REFLECT) ? ~LOBE_REFLECT : ~0u;
    return lobes & (bsdf_is_delta(b, LOBE_TRANSMIT) ? ~LOBE_TRANSMIT : ~0u);
}

// ---- Probabilities of lobes ----

/// Does `lobes` have DIFFUSE, REFLECT, TRANSMIT?
bvec3 has_lobes(uint lobes)
{
    return notEqual(uvec3(lobes) & uvec3(LOBE_DIFFUSE, LOBE_REFLECT, LOBE_TRANSMIT), uvec3(0u));
}

/// Their sum over the lobes that `lobes` has.
float sum_over_lobes(vec3 values, uint lobes)
{
    return dot(values, vec3(has_lobes(lobes)));
}

/// P(lobe | wo) of DIFFUSE, REFLECT, TRANSMIT: the luminance that each scatters, about. Exactly F and 1 - F for smooth
/// clear glass. All zero where the surface absorbs everything.
vec3 bsdf_lobe_probabilities(Bsdf b, vec3 wo)
{
    vec3 rough = vec3(has_lobes(bsdf_rough_lobes(b, LOBE_ALL)));
    float facet = coat_cosine(wo.z, b.alpha);
    vec3 weight = vec3(luminance(b.diffuse * (1.0 - coat_share(b, facet))), luminance(reflect_fresnel(b, facet)),
                       luminance(transmit_fresnel(b, facet)));
#if RESTIRPG_ENERGY_COMPENSATION
    vec2 multiple = multiple_energy(b, wo);
    weight.x += multiple.x + multiple.y;
#endif
    weight *= vec3(has_lobes(b.lobes));
    float sum = weight.x + weight.y + weight.z;
    weight = max(weight, rough * (sum > 0.0 ? MIN_LOBE_PROBABILITY * sum : 1.0));
    return weight / max(weight.x + weight.y + weight.z, 1e-30);
}

/// One LOBE_*'s of them.
float probability_of_lobe(vec3 probabilities, uint lobe)
{
    return lobe == LOBE_DIFFUSE ? probabilities.x : lobe == LOBE_REFLECT ? probabilities.y : probabilities.z;
}

#endif
