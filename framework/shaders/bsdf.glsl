// The one BSDF: glTF metallic-roughness with KHR_materials_{specular, ior, transmission, volume}, as a sum of three lobes that can
// be addressed one by one. Local frame: z is the shading normal on wo's side; wo and wi point away from the surface; wo.z > 0.
//
//   diffuse   (1 - m)(1 - t) base / pi * (1 - Fc(wo)) (1 - Fc(wi)) / (1 - Fc_avg),  Fc the coat's share, see coat_cosine
//   reflect   F D G / (4 cos_o cos_i),  F = mix(dielectric, Schlick(base), m)
//   transmit  (1 - m) t base (1 - F) times Walter et al. 2007's GGX BTDF (solid), or a mirrored reflection (thin)
//
// Two deliberate deviations from glTF's sample BRDF. Diffuse: under glTF's (1 - F(wo.h)) a white surface reaches an albedo of 1.9 at
// grazing; the form above (Shirley et al. 1997, Kelemen & Szirmay-Kalos 2001) is reciprocal, conserves energy, and under a smooth coat
// a white base reflects exactly 1. Thin transmission: a pane has two faces, and the light between them sums to a reflectance
// 2F / (1 + F), as in Mitsuba's `thindielectric`; glTF counts one face.
// Single scattering only: rough surfaces lose energy (benchmarks/results/ggx_energy_loss.md), reciprocity is exact. The diffuse part
// of a half-transparent solid is its outer paint: from inside it absorbs.
#ifndef RESTIRPG_BSDF_GLSL
#define RESTIRPG_BSDF_GLSL

#include "fresnel.glsl"
#include "microfacet.glsl"
#include "sampling.glsl"

const uint LOBE_DIFFUSE = 1u;
const uint LOBE_REFLECT = 2u;
const uint LOBE_TRANSMIT = 4u;
const uint LOBE_ALL = 7u;

/// Linear roughness below which REFLECT and TRANSMIT are exact delta lobes (Mitsuba's reference scenes switch at the same place).
const float DELTA_ROUGHNESS = 0.03;
/// Linear roughness up to which they are "sharp": their own label, never guided, never reconnected (ALGORITHMS O1).
const float SHARP_ROUGHNESS = 0.2;
/// A rough lobe that can be non-zero is chosen at least this often, so that no weight grows without bound (O19).
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
    bool solid;  ///< MATERIAL_SOLID: refracts; else a thin sheet
    bool entering;  ///< wo is on the outside; matters for solids only
};

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
};

/// A direction drawn from a BSDF. `pdf` = 0: the draw carries nothing, the path ends.
struct BsdfSample {
    vec3 wi;
    vec3 weight;  ///< f |cos| / pdf
    float pdf;  ///< per solid angle; of a delta lobe: the probability of having chosen it
    uint lobe;  ///< LOBE_*
    bool delta;
};

BsdfSample no_bsdf_sample(uint lobe)
{
    return BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, lobe, false);
}

// ---- Fresnel terms ----

/// How far from F0 to F90 the dielectric interface is at this cosine: exact Fresnel, normalised.
float coat_position(Bsdf b, float cosine)
{
    if (b.eta == 0.0)
        return schlick_weight(cosine);
    return (fresnel_dielectric(cosine, b.eta) - b.f0) / max(1.0 - b.f0, 1e-6);
}

/// Reflectance of one dielectric interface.
vec3 coat_fresnel(Bsdf b, float cosine)
{
    return clamp(mix(b.coat0, vec3(b.coat90), coat_position(b, cosine)), 0.0, 1.0);
}

/// Both faces of a thin pane, all orders of reflection between them.
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
    vec3 coat = coat_fresnel(b, cosine);
    if (!b.solid)
        return b.transmittance * (1.0 - pane_fresnel(coat));
    return fresnel_dielectric(cosine, b.eta) < 1.0 ? b.transmittance * (1.0 - coat) : vec3(0.0);
}

/// The cosine at which a smooth interface reflects what the rough one seen at `cosine` does: about the mean of wo.h over the facets
/// that wo sees; the identity for alpha = 0. Fitted to quadratures of the GGX lobe for ior 1.2 to 2.4, on which it hardly depends,
/// from the safe side: the reflectance is never 0.005 too small, and 0.03 too large at most for cosines above 0.15. With the macroscopic
/// cosine instead, rough paint would turn black at grazing: the coat would take there what its facets do not reflect.
float coat_cosine(float cosine, float alpha)
{
    float grazing = 0.511 * alpha / (0.228 + alpha);
    float normal = 1.0 - 0.293 * alpha / (0.816 + alpha);
    float linear = 1.222 * alpha * alpha;
    float g2 = grazing * grazing;
    return sqrt(g2 + cosine * (linear + cosine * (normal * normal - g2 - linear)));
}

/// Light that passes the coat towards the diffuse base, for one direction.
vec3 coat_passage(Bsdf b, float cosine)
{
    return 1.0 - coat_fresnel(b, coat_cosine(cosine, b.alpha));
}

// ---- Construction and classes of lobes ----

/// Cosine-weighted mean of coat_position over the hemisphere outside. The factor of alpha bounds the fall of the mean under roughness
/// from below (for ior >= 1.2), so that the diffuse lobe never gains energy.
float coat_average(BsdfParameters p, float alpha)
{
    float smooth_average = p.ior == 0.0 ? 1.0 / 21.0 : p.coatAverage;  // infinite ior: the mean of (1 - cos)^5
    return smooth_average / (1.0 + alpha * (2.6 + 12.4 * alpha));
}

Bsdf make_bsdf(BsdfParameters p)
{
    Bsdf b;
    float ior = abs(p.ior - 1.0) < INDEX_MATCHED ? 1.0 : p.ior;
    b.solid = p.solid && p.transmission > 0.0 && ior > 0.0;
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

    vec3 average = mix(b.coat0, vec3(b.coat90), coat_average(p, b.alpha));
    vec3 base = (1.0 - p.metallic) * p.baseColor;
    b.diffuse = inside ? vec3(0.0) : (1.0 - p.transmission) * base / max(1.0 - average, 1e-4);
    b.transmittance = p.transmission * base;

    b.lobes = 0u;
    if (any(greaterThan(b.diffuse, vec3(0.0))))
        b.lobes |= LOBE_DIFFUSE;
    if (p.metallic > 0.0 || b.coat90 > 0.0)
        b.lobes |= LOBE_REFLECT;
    if (any(greaterThan(b.transmittance, vec3(0.0))))
        b.lobes |= LOBE_TRANSMIT;
    return b;
}

/// Is this lobe an exact delta? Refraction between equal indices is one at any roughness.
bool bsdf_is_delta(Bsdf b, uint lobe)
{
    return lobe != LOBE_DIFFUSE && (b.roughness < DELTA_ROUGHNESS || (lobe == LOBE_TRANSMIT && b.solid && b.eta == 1.0));
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

/// 1 for DIFFUSE, REFLECT, TRANSMIT where `lobes` has them, else 0.
vec3 lobe_flags(uint lobes)
{
    return vec3(notEqual(uvec3(lobes) & uvec3(LOBE_DIFFUSE, LOBE_REFLECT, LOBE_TRANSMIT), uvec3(0u)));
}

/// P(lobe | wo) of DIFFUSE, REFLECT, TRANSMIT: the luminance that each scatters, about. Exactly F and 1 - F for smooth clear glass.
/// All zero where the surface absorbs everything.
vec3 bsdf_lobe_probabilities(Bsdf b, vec3 wo)
{
    vec3 present = lobe_flags(b.lobes);
    vec3 rough = vec3(1.0, bsdf_is_delta(b, LOBE_REFLECT) ? 0.0 : 1.0, bsdf_is_delta(b, LOBE_TRANSMIT) ? 0.0 : 1.0);
    float facet = coat_cosine(wo.z, b.alpha);
    vec3 weight = present * vec3(luminance(b.diffuse * (1.0 - coat_fresnel(b, facet))), luminance(reflect_fresnel(b, facet)),
                                 luminance(transmit_fresnel(b, facet)));
    float sum = weight.x + weight.y + weight.z;
    weight = max(weight, present * rough * (sum > 0.0 ? MIN_LOBE_PROBABILITY * sum : 1.0));
    return weight / max(weight.x + weight.y + weight.z, 1e-30);
}

/// P(lobe | wo) of one LOBE_*.
float bsdf_lobe_probability(Bsdf b, vec3 wo, uint lobe)
{
    vec3 p = bsdf_lobe_probabilities(b, wo);
    return lobe == LOBE_DIFFUSE ? p.x : lobe == LOBE_REFLECT ? p.y : p.z;
}

// ---- Rough lobes: value and density ----

/// The half vector of refraction, on wo's side; zero when wi cannot be refracted from wo.
vec3 refraction_half_vector(vec3 wo, vec3 wi, float eta)
{
    vec3 h = normalize(wo + eta * wi);
    h = h.z < 0.0 ? -h : h;
    return dot(wo, h) > 0.0 && dot(wi, h) < 0.0 ? h : vec3(0.0);
}

/// f of rough refraction, in radiance: Walter 2007 eq. 21; the (n_i / n_o)^2 of a radiance that crosses the interface is in it.
vec3 eval_refraction(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = refraction_half_vector(wo, wi, b.eta);
    if (h.z <= 0.0)
        return vec3(0.0);
    float o = dot(wo, h);
    float i = dot(wi, h);
    float denominator = o + b.eta * i;
    float shape = ggx_d(h, b.alpha) * ggx_visibility_across(wo.z, -wi.z, b.alpha) * o * -i / (denominator * denominator);
    return transmit_fresnel(b, o) * shape;
}

/// Density over wi: that of h times |dh / dwi| (Walter 2007 eq. 17).
float pdf_refraction(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = refraction_half_vector(wo, wi, b.eta);
    if (h.z <= 0.0)
        return 0.0;
    float i = dot(wi, h);
    float denominator = dot(wo, h) + b.eta * i;
    return pdf_ggx_vndf(wo, h, b.alpha) * b.eta * b.eta * -i / (denominator * denominator);
}

/// D G / (4 cos_o cos_i) of a reflection; `h` receives the half vector.
float eval_reflection(Bsdf b, vec3 wo, vec3 wi, out vec3 h)
{
    h = normalize(wo + wi);
    return ggx_d(h, b.alpha) * ggx_visibility(wo.z, wi.z, b.alpha);
}

float pdf_reflection(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = normalize(wo + wi);
    return 0.25 * ggx_g1_over_cosine(wo.z, b.alpha) * ggx_d(h, b.alpha);
}

/// f(wo, wi) of the rough lobes in `mask`, without the cosine, 1/sr. Delta lobes are 0 here.
vec3 bsdf_eval(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    uint lobes = bsdf_rough_lobes(b, mask);
    vec3 f = vec3(0.0);
    vec3 h;
    if (wo.z <= 0.0 || wi.z == 0.0)
        return f;
    if (wi.z > 0.0) {
        if ((lobes & LOBE_DIFFUSE) != 0u)
            f += b.diffuse * INV_PI * coat_passage(b, wo.z) * coat_passage(b, wi.z);
        if ((lobes & LOBE_REFLECT) != 0u) {
            float shape = eval_reflection(b, wo, wi, h);
            f += reflect_fresnel(b, dot(wo, h)) * shape;
        }
    } else if ((lobes & LOBE_TRANSMIT) != 0u) {
        if (b.solid) {
            f += eval_refraction(b, wo, wi);
        } else {
            float shape = eval_reflection(b, wo, vec3(wi.xy, -wi.z), h);
            f += transmit_fresnel(b, dot(wo, h)) * shape;
        }
    }
    return f;
}

/// Density of bsdf_sample_lobe over wi for one rough lobe, 1/sr.
float bsdf_lobe_pdf(Bsdf b, vec3 wo, vec3 wi, uint lobe)
{
    if (wo.z <= 0.0 || (lobe & bsdf_rough_lobes(b, lobe)) == 0u || (wi.z > 0.0) == (lobe == LOBE_TRANSMIT) || wi.z == 0.0)
        return 0.0;
    if (lobe == LOBE_DIFFUSE)
        return pdf_cosine_hemisphere(wi.z);
    if (lobe == LOBE_REFLECT)
        return pdf_reflection(b, wo, wi);
    return b.solid ? pdf_refraction(b, wo, wi) : pdf_reflection(b, wo, vec3(wi.xy, -wi.z));
}

/// Sum over the rough lobes in `mask` of P(lobe | wo) pdf_lobe(wi), 1/sr.
float bsdf_pdf(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    if (wo.z <= 0.0)
        return 0.0;
    vec3 p = bsdf_lobe_probabilities(b, wo);
    return dot(p, vec3(bsdf_lobe_pdf(b, wo, wi, LOBE_DIFFUSE & mask), bsdf_lobe_pdf(b, wo, wi, LOBE_REFLECT & mask),
                       bsdf_lobe_pdf(b, wo, wi, LOBE_TRANSMIT & mask)));
}

// ---- Sampling ----

/// The one direction of a delta lobe, with the lobe's throughput as weight and pdf 1.
BsdfSample sample_delta_lobe(Bsdf b, vec3 wo, uint lobe)
{
    BsdfSample s = BsdfSample(vec3(-wo.xy, wo.z), vec3(0.0), 1.0, lobe, true);
    if (lobe == LOBE_REFLECT) {
        s.weight = reflect_fresnel(b, wo.z);
        return s;
    }
    s.weight = transmit_fresnel(b, wo.z);
    s.wi = -wo;
    if (b.solid) {
        if (!refract_direction(wo, vec3(0.0, 0.0, 1.0), b.eta, s.wi))
            return no_bsdf_sample(lobe);
        s.weight /= b.eta * b.eta;  // radiance is compressed on the denser side
    }
    return s;
}

/// A direction of one lobe. Rough: pdf is that lobe's own density and weight its f |cos| / pdf. Delta: pdf 1, weight its throughput.
BsdfSample bsdf_sample_lobe(Bsdf b, vec3 wo, uint lobe, vec2 u)
{
    if (wo.z <= 0.0 || (b.lobes & lobe) == 0u)
        return no_bsdf_sample(lobe);
    if (bsdf_is_delta(b, lobe))
        return sample_delta_lobe(b, wo, lobe);
    BsdfSample s = no_bsdf_sample(lobe);
    if (lobe == LOBE_DIFFUSE) {
        s.wi = sample_cosine_hemisphere(u);
    } else {
        vec3 h = sample_ggx_vndf(wo, b.alpha, u);
        if (lobe == LOBE_TRANSMIT && b.solid) {
            if (!refract_direction(wo, h, b.eta, s.wi) || s.wi.z >= 0.0)
                return s;
        } else {
            s.wi = normalize(2.0 * dot(wo, h) * h - wo);
            if (s.wi.z <= 0.0)
                return s;
            s.wi.z = lobe == LOBE_TRANSMIT ? -s.wi.z : s.wi.z;
        }
    }
    s.pdf = bsdf_lobe_pdf(b, wo, s.wi, lobe);
    s.weight = s.pdf > 0.0 ? bsdf_eval(b, wo, s.wi, lobe) * (abs(s.wi.z) / s.pdf) : vec3(0.0);
    return s;
}

/// The lobe that u in [0, 1) selects among those in `mask`, with probabilities P(lobe | wo) renormalised; 0 when there is none.
uint bsdf_select_lobe(Bsdf b, vec3 wo, uint mask, float u)
{
    vec3 p = bsdf_lobe_probabilities(b, wo) * lobe_flags(mask);
    float at = u * (p.x + p.y + p.z);
    if (at < p.x)
        return LOBE_DIFFUSE;
    if (at < p.x + p.y)
        return LOBE_REFLECT;
    return p.z > 0.0 ? LOBE_TRANSMIT : p.y > 0.0 ? LOBE_REFLECT : p.x > 0.0 ? LOBE_DIFFUSE : 0u;
}

/// One direction of the whole BSDF. Rough: pdf is bsdf_pdf over all lobes and weight the whole f |cos| / pdf. Delta: pdf is
/// P(lobe | wo), weight the lobe's throughput over it.
BsdfSample bsdf_sample(Bsdf b, vec3 wo, float u_lobe, vec2 u)
{
    uint lobe = bsdf_select_lobe(b, wo, LOBE_ALL, u_lobe);
    BsdfSample s = bsdf_sample_lobe(b, wo, lobe, u);
    if (s.pdf <= 0.0)
        return s;
    if (s.delta) {
        s.pdf = bsdf_lobe_probability(b, wo, lobe);
        s.weight /= s.pdf;
        return s;
    }
    s.pdf = bsdf_pdf(b, wo, s.wi, LOBE_ALL);
    s.weight = bsdf_eval(b, wo, s.wi, LOBE_ALL) * (abs(s.wi.z) / s.pdf);
    return s;
}

#endif
