// Isotropic GGX microfacets in the local frame (z = normal): distribution, height-correlated Smith masking, and
// sampling of the visible normals. Forms are chosen so that alpha = 1e-3 and grazing directions keep their digits in
// float32.
#ifndef RESTIRPG_MICROFACET_GLSL
#define RESTIRPG_MICROFACET_GLSL

#include "prelude.glsl"

/// Normal distribution D(h), Walter et al. 2007 eq. 33. Written in sin^2 / alpha^2: 1 - cos^2 would cancel for small
/// alpha.
float ggx_d(vec3 h, float alpha)
{
    float a2 = alpha * alpha;
    float t = dot(h.xy, h.xy) / a2 + h.z * h.z;
    return 1.0 / (PI * a2 * t * t);
}

/// sqrt(alpha^2 sin^2 + cos^2): |cos| (1 + 2 Lambda) of Smith's masking.
float ggx_projected(float cosine, float alpha)
{
    float a2 = alpha * alpha;
    return sqrt(a2 + (1.0 - a2) * cosine * cosine);
}

/// G1(w) / |cos|. Smith masking over the cosine, finite at grazing.
float ggx_g1_over_cosine(float cosine, float alpha)
{
    return 2.0 / (cosine + ggx_projected(cosine, alpha));
}

/// G2(wo, wi) / (4 |cos_o| |cos_i|), both directions on one side. Heitz 2014 eq. 99 (height-correlated).
float ggx_visibility(float cos_o, float cos_i, float alpha)
{
    return 0.5 / (cos_i * ggx_projected(cos_o, alpha) + cos_o * ggx_projected(cos_i, alpha));
}

/// A normal visible from wo. Dupuy & Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
vec3 sample_ggx_vndf(vec3 wo, float alpha, vec2 u)
{
    vec3 w = normalize(vec3(alpha * wo.xy, wo.z));
    float phi = 2.0 * PI * u.x;
    float z = (1.0 - u.y) * (1.0 + w.z) - w.z;
    float r = sqrt(max(1.0 - z * z, 0.0));
    vec3 h = vec3(r * cos(phi), r * sin(phi), z) + w;
    return normalize(vec3(alpha * h.xy, max(h.z, 1e-7)));
}

/// Density of sample_ggx_vndf over solid angle of h: G1(wo) max(0, wo.h) D(h) / cos_o.
float pdf_ggx_vndf(vec3 wo, vec3 h, float alpha)
{
    return ggx_g1_over_cosine(wo.z, alpha) * max(dot(wo, h), 0.0) * ggx_d(h, alpha);
}

#endif
