// A mixture of four von Mises-Fisher lobes, as vectors over the lobes [shaders/README: The MAP fit].
#ifndef RESTIRPG_VMF_MIXTURE_GLSL
#define RESTIRPG_VMF_MIXTURE_GLSL

#include "vmf.glsl"

/// One for each component of a vector.
const uint MIXTURE_LOBES = 4u;

/// Lobe k in component k.
struct VmfMixture {
    vec4 x, y, z;  ///< mean directions, unit
    vec4 kappa;
    vec4 weight;  ///< sum 1
};

/// Concentration that a new cell's lobes have.
const float NEW_LOBE_KAPPA = 3.0;

/// log of the density of each lobe times its weight.
vec4 log_lobe_densities(VmfMixture m, vec3 w)
{
    vec4 dx = w.x - m.x;
    vec4 dy = w.y - m.y;
    vec4 dz = w.z - m.z;
    vec4 result = -0.5 * m.kappa * (dx * dx + dy * dy + dz * dz);
    for (uint k = 0u; k < MIXTURE_LOBES; ++k)
        result[k] += log(max(m.weight[k], 1e-30) * vmf_normalization(m.kappa[k]));
    return result;
}

/// Each lobe's share in explaining a sample; sums to 1. `log_density` is the mixture's.  [E-step of EM]
vec4 responsibilities(VmfMixture m, vec3 w, out float log_density)
{
    vec4 l = log_lobe_densities(m, w);
    float largest = max(max(l.x, l.y), max(l.z, l.w));
    vec4 e = exp(l - largest);
    float sum = dot(e, vec4(1.0));
    log_density = largest + log(sum);
    return e / sum;
}

/// Where a cell starts: lobes spread evenly over the hemisphere of its normal. No two are alike: EM would keep them so.
VmfMixture new_mixture(vec3 normal)
{
    const float GOLDEN_ANGLE = 2.39996323;
    mat3 local_frame = make_frame(normal);
    VmfMixture m;
    for (uint k = 0u; k < MIXTURE_LOBES; ++k) {
        float z = 1.0 - (float(k) + 0.5) / float(MIXTURE_LOBES);
        float r = sqrt(1.0 - z * z);
        float phi = GOLDEN_ANGLE * float(k);
        vec3 w = to_world(local_frame, vec3(r * cos(phi), r * sin(phi), z));
        m.x[k] = w.x;
        m.y[k] = w.y;
        m.z[k] = w.z;
    }
    m.kappa = vec4(NEW_LOBE_KAPPA);
    m.weight = vec4(1.0 / float(MIXTURE_LOBES));
    return m;
}

vec3 lobe_direction(VmfMixture m, uint k)
{
    return vec3(m.x[k], m.y[k], m.z[k]);
}

/// The lobe that a number in [0, 1) selects by the weights.
uint select_lobe(VmfMixture m, float u)
{
    uint k = 0u;
    for (; k + 1u < MIXTURE_LOBES; ++k) {
        u -= m.weight[k];
        if (u < 0.0)
            break;
    }
    return k;
}

/// A mixture to sample from and to evaluate, many times.
struct PlacedMixture {
    VmfMixture mixture;
    vec4 amplitude;  ///< density of each lobe on its axis, times its weight, 1/sr
};

PlacedMixture place_mixture(VmfMixture m)
{
    vec4 normalizations =
        vec4(vmf_normalization(m.kappa.x), vmf_normalization(m.kappa.y), vmf_normalization(m.kappa.z), vmf_normalization(m.kappa.w));
    return PlacedMixture(m, m.weight * normalizations);
}

/// A unit direction with density mixture_pdf.
vec3 sample_mixture(PlacedMixture p, vec3 u)
{
    uint k = select_lobe(p.mixture, u.z);
    return sample_vmf(lobe_direction(p.mixture, k), p.mixture.kappa[k], u.xy);
}

/// Density of the unit direction w, 1/sr.
float mixture_pdf(PlacedMixture p, vec3 w)
{
    vec4 dx = w.x - p.mixture.x;
    vec4 dy = w.y - p.mixture.y;
    vec4 dz = w.z - p.mixture.z;
    return dot(p.amplitude, exp(-0.5 * p.mixture.kappa * (dx * dx + dy * dy + dz * dz)));
}

#endif
