// A vertex of a path, with its guide, and how the path leaves it.
#ifndef RESTIRPG_PATH_TRACER_VERTEX_GLSL
#define RESTIRPG_PATH_TRACER_VERTEX_GLSL

#include "guide/guide.glsl"
#include "bsdf/labels.glsl"
#include "math/random.glsl"

/// Where a path scatters, and what guides it there.
struct Vertex {
    ShadingPoint point;
    uint material;
    bool guided;
    bool opaque;  ///< no smooth lobe refracts to the other side
    float alpha;  ///< probability of the BSDF within the smooth label, where guided
    Guide guide;
};

/// `guide`: what may draw the bounce here, 0: no guide; `alpha`: probability of the BSDF where the guide has learnt none.
Vertex make_vertex(Surface surface, vec3 wo, uvec2 pixel, uint bounce, Address guide, float alpha)
{
    Vertex v;
    v.point = shade_surface(surface, wo);
    v.material = surface.material;
    v.guided = false;
#if GUIDED
    uint lobes = label_lobes(v.point.bsdf, LABEL_SMOOTH);
    v.opaque = (lobes & LOBE_TRANSMIT) == 0u;
    v.guided = guide != 0ul && lobes != 0u &&
               guide_lookup(guide, GuideQuery(surface.position, v.point.normal, wo, surface.material, pixel, bounce), v.guide);
    v.alpha = v.guided ? guide_alpha(v.guide, alpha) : 1.0;
#endif
    return v;
}

/// A direction of the guide. Over an opaque surface what points below it is reflected, so that no sample is lost [shaders/README: Guided sampling].
vec3 sample_guided(Vertex v, vec3 u)
{
    vec3 w = guide_sample(v.guide, u);
    float cosine = dot(v.point.normal, w);
    return v.opaque && cosine < 0.0 ? w - 2.0 * cosine * v.point.normal : w;
}

/// Density of sample_guided, 1/sr.
float guided_pdf(Vertex v, vec3 w)
{
    float pdf = guide_pdf(v.guide, w);
    if (!v.opaque)
        return pdf;
    float cosine = dot(v.point.normal, w);
    return cosine > 0.0 ? pdf + guide_pdf(v.guide, w - 2.0 * cosine * v.point.normal) : 0.0;
}

/// What one-sample MIS with the guide adds to the density of a direction within the smooth label, which is smooth_pdf by the BSDF alone.
float guide_correction(Vertex v, vec3 w, float smooth_pdf)
{
    float guided = label_probability(v.point.bsdf, v.point.lobe_probabilities, LABEL_SMOOTH) * guided_pdf(v, w);
    return (1.0 - v.alpha) * (guided - smooth_pdf);
}

/// Density of scatter over all rough lobes, 1/sr. Sharp lobes are never guided.
float scatter_pdf(Vertex v, vec3 wi_local, vec3 wi)
{
    ShadingPoint p = v.point;
    vec3 pdfs = p.lobe_probabilities * bsdf_lobe_pdfs(p.bsdf, p.wo, wi_local, LOBE_ALL);
    float unguided = pdfs.x + pdfs.y + pdfs.z;
    if (!v.guided)
        return unguided;
    return unguided + guide_correction(v, wi, sum_over_lobes(pdfs, label_lobes(p.bsdf, LABEL_SMOOTH)));
}

/// A scattered direction (BsdfSample::wi in the local frame) by the BSDF or, in the smooth label, by the guide.
BsdfSample scatter(Vertex v, RandomKey key, uint bounce)
{
    Bsdf bsdf = v.point.bsdf;
    vec4 numbers = random4(key, bounce, RANDOM_DIRECTION);
    if (!v.guided)
        return bsdf_sample(bsdf, v.point.lobe_probabilities, v.point.wo, numbers.z, numbers.xy);
    uint lobe = bsdf_select_lobe(v.point.lobe_probabilities, LOBE_ALL, numbers.z);
    BsdfSample s;
    if (label_of_lobe(bsdf, lobe) == LABEL_SMOOTH && random1(key, bounce, RANDOM_TECHNIQUE) >= v.alpha) {
        s = no_bsdf_sample(lobe);
        s.wi = to_local(v.point.local_frame, sample_guided(v, vec3(numbers.xy, random1(key, bounce, RANDOM_GUIDE_LOBE))));
        if (s.wi == vec3(0.0))
            return s;
    } else {
        s = bsdf_sample_lobe(bsdf, v.point.wo, lobe, numbers.xy);
        if (s.pdf <= 0.0)
            return s;
        if (s.delta) {
            s.pdf = probability_of_lobe(v.point.lobe_probabilities, lobe);
            s.weight /= s.pdf;
            return s;
        }
    }
    s.pdf = scatter_pdf(v, s.wi, to_world(v.point.local_frame, s.wi));
    s.weight = s.pdf > 0.0 ? bsdf_eval(bsdf, v.point.wo, s.wi, LOBE_ALL) * (abs(s.wi.z) / s.pdf) : vec3(0.0);
    return s;
}

#endif
