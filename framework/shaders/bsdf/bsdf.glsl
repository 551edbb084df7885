// The BSDF's value, density and sampling, lobe by lobe or whole. The model itself is in bsdf_model.glsl.
#ifndef RESTIRPG_BSDF_GLSL
#define RESTIRPG_BSDF_GLSL

#include "bsdf_model.glsl"
#include "microfacet.glsl"
#include "math/sampling.glsl"

/// A direction drawn from a BSDF. `pdf` = 0: the draw carries nothing, the path ends.
struct BsdfSample {
    vec3 wi;
    vec3 weight;  ///< f |cos| / pdf; bsdf_sample_lobe leaves that of rough lobes at 0
    float pdf;  ///< per solid angle; of a delta lobe: the probability of having chosen it
    uint lobe;  ///< LOBE_*
    bool delta;
};

BsdfSample no_bsdf_sample(uint lobe)
{
    return BsdfSample(vec3(0.0, 0.0, 1.0), vec3(0.0), 0.0, lobe, false);
}

// ---- Rough lobes: value and density ----
//
// What several terms need is worked out once, without branches, and then selected: the pixels of one vector take both
// sides of a branch anyhow, and compilers merge equal terms only where no branch lies between.

/// The half vector of refraction, on wo's side; zero when wi cannot be refracted from wo.
vec3 refraction_half_vector(vec3 wo, vec3 wi, float eta)
{
    vec3 h = normalize(wo + eta * wi);
    h = h.z < 0.0 ? -h : h;
    return dot(wo, h) > 0.0 && dot(wi, h) < 0.0 ? h : vec3(0.0);
}

bool is_refracted(Bsdf b, vec3 wi)
{
    return b.solid && wi.z < 0.0;
}

/// The normal of the facets that scatter wo into wi, on wo's side: by refraction, or by reflection, mirrored to the far
/// side by a thin sheet. Zero where there are none.
vec3 facet_normal(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 reflecting = normalize(wo + vec3(wi.xy, abs(wi.z)));
    vec3 refracting = refraction_half_vector(wo, wi, b.eta);
    return is_refracted(b, wi) ? refracting : reflecting;
}

/// f of the diffuse lobe for wi above the surface.
vec3 eval_diffuse(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 f = b.diffuse * INV_PI * coat_passage(b, wo.z) * coat_passage(b, wi.z);
    return wi.z > 0.0 ? f : vec3(0.0);
}

/// f of the facets on wi's side: of REFLECT above the surface, of TRANSMIT below it. Refraction is in radiance, Walter
/// 2007 eq. 21; the (n_i / n_o)^2 of a radiance that crosses the interface is in it.
vec3 eval_facets(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = facet_normal(b, wo, wi);
    float o = dot(wo, h);
    float i = dot(wi, h);
    float shape = ggx_d(h, b.alpha) * ggx_visibility(wo.z, abs(wi.z), b.alpha);
    float denominator = o + b.eta * i;
    // 4: G2 across the interface has no 1/4 (Mitsuba and pbrt-v4: 1 / (1 + Lambda_o + Lambda_i); the exact form is a Beta
    // function, Heitz et al. 2016, a little smaller at grazing).
    float refraction = 4.0 * shape * o * -i / (denominator * denominator);
    vec3 reflected = reflect_fresnel(b, o);
    vec3 transmitted = transmit_fresnel(b, o);
    vec3 f = wi.z > 0.0 ? reflected * shape : transmitted * (b.solid ? refraction : shape);
    return h.z > 0.0 ? f : vec3(0.0);
}

/// The rough lobes of `mask` that scatter between wo and wi at all, and so have a value and a density.
uint scattering_lobes(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    uint side = wi.z > 0.0 ? LOBE_DIFFUSE | LOBE_REFLECT : LOBE_TRANSMIT;
#if RESTIRPG_ENERGY_COMPENSATION
    side |= LOBE_DIFFUSE;  // scatters to both sides
#endif
    return wo.z > 0.0 && wi.z != 0.0 ? bsdf_rough_lobes(b, mask) & side : 0u;
}

/// f(wo, wi) of the rough lobes, without the cosine, 1/sr. Of REFLECT and TRANSMIT only one scatters to wi's side.
struct LobeValues {
    vec3 diffuse;
    vec3 facets;
};

LobeValues bsdf_lobe_values(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    uint lobes = scattering_lobes(b, wo, wi, mask);
    vec3 diffuse = eval_diffuse(b, wo, wi);
#if RESTIRPG_ENERGY_COMPENSATION
    diffuse += eval_multiple(b, wo, wi);
#endif
    vec3 facets = eval_facets(b, wo, wi);
    return LobeValues((lobes & LOBE_DIFFUSE) != 0u ? diffuse : vec3(0.0), (lobes & ~LOBE_DIFFUSE) != 0u ? facets : vec3(0.0));
}

/// f(wo, wi) of the rough lobes in `mask`, without the cosine, 1/sr. Delta lobes are 0 here.
vec3 bsdf_eval(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    LobeValues f = bsdf_lobe_values(b, wo, wi, mask);
    return f.diffuse + f.facets;
}

float pdf_diffuse(Bsdf b, vec3 wo, vec3 wi)
{
#if RESTIRPG_ENERGY_COMPENSATION
    float across = across_probability(b, wo);
    return pdf_cosine_hemisphere(abs(wi.z)) * (wi.z < 0.0 ? across : 1.0 - across);
#else
    return pdf_cosine_hemisphere(wi.z);
#endif
}

/// Density of REFLECT above the surface, of TRANSMIT below it. That of h times |dh / dwi| (refraction: Walter 2007
/// eq. 17).
float pdf_facets(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = facet_normal(b, wo, wi);
    float i = dot(wi, h);
    float denominator = dot(wo, h) + b.eta * i;
    float refraction = pdf_ggx_vndf(wo, h, b.alpha) * b.eta * b.eta * -i / (denominator * denominator);
    float reflection = 0.25 * ggx_g1_over_cosine(wo.z, b.alpha) * ggx_d(h, b.alpha);
    float pdf = is_refracted(b, wi) ? refraction : reflection;
    return h.z > 0.0 ? pdf : 0.0;
}

/// Densities over wi of the rough lobes in `mask`, each drawn alone: of DIFFUSE, REFLECT, TRANSMIT, 1/sr.
vec3 bsdf_lobe_pdfs(Bsdf b, vec3 wo, vec3 wi, uint mask)
{
    bvec3 lobes = has_lobes(scattering_lobes(b, wo, wi, mask));
    float facets = pdf_facets(b, wo, wi);
    return mix(vec3(0.0), vec3(pdf_diffuse(b, wo, wi), facets, facets), lobes);
}

/// Density of bsdf_sample_lobe over wi for one rough lobe, 1/sr.
float bsdf_lobe_pdf(Bsdf b, vec3 wo, vec3 wi, uint lobe)
{
    vec3 pdfs = bsdf_lobe_pdfs(b, wo, wi, lobe);
    return pdfs.x + pdfs.y + pdfs.z;
}

/// Sum over the rough lobes in `mask` of P(lobe | wo) pdf_lobe(wi), 1/sr. `probabilities`: bsdf_lobe_probabilities.
float bsdf_pdf(Bsdf b, vec3 probabilities, vec3 wo, vec3 wi, uint mask)
{
    return dot(probabilities, bsdf_lobe_pdfs(b, wo, wi, mask));
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

/// A direction by the cosine; with energy compensation sometimes of the other side.
vec3 sample_diffuse(Bsdf b, vec3 wo, vec2 u)
{
#if RESTIRPG_ENERGY_COMPENSATION
    float across = across_probability(b, wo);
    if (u.x < across)
        return sample_cosine_hemisphere(vec2(u.x / across, u.y)) * vec3(1.0, 1.0, -1.0);
    u.x = min((u.x - across) / max(1.0 - across, 1e-6), 0.99999994);
#endif
    return sample_cosine_hemisphere(u);
}

/// A direction of one lobe. Rough: pdf is that lobe's own density, and there is no weight. Delta: pdf 1, weight its
/// throughput.
BsdfSample bsdf_sample_lobe(Bsdf b, vec3 wo, uint lobe, vec2 u)
{
    if (wo.z <= 0.0 || (b.lobes & lobe) == 0u)
        return no_bsdf_sample(lobe);
    if (bsdf_is_delta(b, lobe))
        return sample_delta_lobe(b, wo, lobe);
    BsdfSample s = no_bsdf_sample(lobe);
    if (lobe == LOBE_DIFFUSE) {
        s.wi = sample_diffuse(b, wo, u);
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
    return s;
}

/// The lobe that u in [0, 1) selects among those in `mask`, with probabilities P(lobe | wo) renormalised; 0 when there
/// is none.
uint bsdf_select_lobe(vec3 probabilities, uint mask, float u)
{
    vec3 p = probabilities * vec3(has_lobes(mask));
    float at = u * (p.x + p.y + p.z);
    if (at < p.x)
        return LOBE_DIFFUSE;
    if (at < p.x + p.y)
        return LOBE_REFLECT;
    return p.z > 0.0 ? LOBE_TRANSMIT : p.y > 0.0 ? LOBE_REFLECT : p.x > 0.0 ? LOBE_DIFFUSE : 0u;
}

/// One direction of the whole BSDF. Rough: pdf is bsdf_pdf over all lobes and weight the whole f |cos| / pdf. Delta:
/// pdf is P(lobe | wo), weight the lobe's throughput over it.
BsdfSample bsdf_sample(Bsdf b, vec3 probabilities, vec3 wo, float u_lobe, vec2 u)
{
    uint lobe = bsdf_select_lobe(probabilities, LOBE_ALL, u_lobe);
    BsdfSample s = bsdf_sample_lobe(b, wo, lobe, u);
    if (s.pdf <= 0.0)
        return s;
    if (s.delta) {
        s.pdf = probability_of_lobe(probabilities, lobe);
        s.weight /= s.pdf;
        return s;
    }
    s.pdf = bsdf_pdf(b, probabilities, wo, s.wi, LOBE_ALL);
    s.weight = bsdf_eval(b, wo, s.wi, LOBE_ALL) * (abs(s.wi.z) / s.pdf);
    return s;
}

#endif
