// The von Mises-Fisher distribution on the sphere [shaders/README: The von Mises-Fisher distribution], stable from kappa = 0 to 32000 in single precision.
#ifndef RESTIRPG_VMF_GLSL
#define RESTIRPG_VMF_GLSL

#include "sampling.glsl"

/// 1 - exp(-x) without cancellation for small x >= 0.
float one_minus_exp(float x)
{
    return x < 0.2 ? x * (1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0)))) : 1.0 - exp(-x);
}

/// log(1 + z) without cancellation near 0, z > -1.
float log_one_plus(float z)
{
    return abs(z) < 0.1 ? z * (1.0 - z * (1.0 / 2.0 - z * (1.0 / 3.0 - z * (1.0 / 4.0 - z * (1.0 / 5.0 - z / 6.0))))) : log(1.0 + z);
}

/// A lobe of less concentration is taken for uniform: single precision would lose its shape.
const float LEAST_KAPPA = 1e-3;

/// Near 1 a mean cosine has too few digits left to tell larger concentrations apart.
const float LARGEST_VMF_KAPPA = 32000.0;

/// The concentration of a mean cosine, approximately, at most LARGEST_VMF_KAPPA.  [Banerjee et al. 2005]
float vmf_kappa(float mean_cosine)
{
    mean_cosine = min(mean_cosine, 1.0 - 1.0 / LARGEST_VMF_KAPPA);
    float kappa = mean_cosine * (3.0 - mean_cosine * mean_cosine) / (1.0 - mean_cosine * mean_cosine);
    return kappa < LEAST_KAPPA ? 0.0 : kappa;
}

/// The density on the axis, 1/sr: kappa / (2 pi (1 - e^{-2 kappa})).
float vmf_normalization(float kappa)
{
    return kappa < 0.1 ? (1.0 + kappa + kappa * kappa / 3.0) * 0.25 * INV_PI : kappa * 0.5 * INV_PI / one_minus_exp(2.0 * kappa);
}

/// Density of w about the unit axis mu, 1/sr. kappa = 0: uniform.
float vmf_pdf(vec3 w, vec3 mu, float kappa)
{
    // |w - mu|^2 / 2 = 1 - mu.w, with all of its digits for narrow lobes.
    vec3 d = w - mu;
    return vmf_normalization(kappa) * exp(-0.5 * kappa * dot(d, d));
}

/// A direction with density vmf_pdf.
vec3 sample_vmf(vec3 mu, float kappa, vec2 u)
{
    if (kappa == 0.0)
        return sample_sphere(u);
    // t = 1 - cos.
    float t = clamp(-log_one_plus(-u.x * one_minus_exp(2.0 * kappa)) / kappa, 0.0, 2.0);
    float sine = sqrt(t * (2.0 - t));
    float phi = 2.0 * PI * u.y;
    return to_world(make_frame(mu), vec3(sine * cos(phi), sine * sin(phi), 1.0 - t));
}

#endif
