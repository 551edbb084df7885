// The BSDF's value, density and sampling, lobe by lobe or whole. The model itself is in bsdf_model.glsl.
#ifndef RESTIRPG_BSDF_GLSL
#define RESTIRPG_BSDF_GLSL

#include "bsdf_model.glsl"
#include "microfacet.glsl"
#include "math/sampling.glsl"

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

// ---- Rough lobes: value and density ----

/// The half vector of refraction, on wo's side; zero when wi cannot be refracted from wo.
vec3 refraction_half_vector(vec3 wo, vec3 wi, float eta)
{
    vec3 h = normalize(wo + eta * wi);
    h = h.z < 0.0 ? -h : h;
    return dot(wo, h) > 0.0 && dot(wi, h) < 0.0 ? h : vec3(0.0);
}

/// f of rough refraction, in radiance: Walter 2007 eq. 21; the (n_i / n_o)^2 of a radiance that crosses the interface
/// is in it.
vec3 eval_refraction(Bsdf b, vec3 wo, vec3 wi)
{
    vec3 h = refraction_half_vector(wo, wi, b.eta);
    if (h.z <= 0.0)
        return vec3(0.0);
    float o = dot(wo, h);
    float i = dot(wi, h);
    float denominator = o + b.eta * i;
    float shape = ggx_d(h, b.alpha) * ggx_visibility_across(wo.z, -wi.z, b.alpha);
    return transmit_fresnel(b, o) * (shape * o * -i / (denominator * denominator));
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
#if RESTIRPG_ENERGY_COMPENSATION
    if ((lobes & LOBE_DIFFUSE) != 0u)
        f += eval_many(b, wo, wi);
#endif
    return f;
}

/// Density of bsdf_sample_lobe over wi for one rough lobe, 1/sr.
float bsdf_lobe_pdf(Bsdf b, vec3 wo, vec3 wi, uint lobe)
{
    bool crosses = wi.z < 0.0;
    if (wo.z <= 0.0 || wi.z == 0.0 || bsdf_rough_lobes(b, lobe) == 0u)
        return 0.0;
#if RESTIRPG_ENERGY_COMPENSATION
    if (lobe == LOBE_DIFFUSE) {
        float across = across_probability(b, wo);
        return pdf_cosine_hemisphere(abs(wi.z)) * (crosses ? across : 1.0 - across);
    }
#endif
    if (crosses != (lobe == LOBE_TRANSMIT))
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

/// A direction of one lobe. Rough: pdf is that lobe's own density and weight its f |cos| / pdf. Delta: pdf 1, weight
/// its throughput.
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
    s.weight = s.pdf > 0.0 ? bsdf_eval(b, wo, s.wi, lobe) * (abs(s.wi.z) / s.pdf) : vec3(0.0);
    return s;
}

/// The lobe that u in [0, 1) selects among those in `mask`, with probabilities P(lobe | wo) renormalised; 0 when there
/// is none.
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

/// One direction of the whole BSDF. Rough: pdf is bsdf_pdf over all lobes and weight the whole f |cos| / pdf. Delta:
/// pdf is P(lobe | wo), weight the lobe's throughput over it.
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
