// The M-step: lobes from sufficient statistics, with priors.  [Ruppert et al. 2020, section 4] [shaders/README: The MAP fit]
#ifndef RESTIRPG_GUIDING_FIT_GLSL
#define RESTIRPG_GUIDING_FIT_GLSL

#include "guide/guiding_grid_types.h"
#include "math/vmf_mixture.glsl"

/// A cell's statistics: sums over the samples of each lobe's share and of share times direction.
struct FitSums {
    vec4 x, y, z;
    vec4 share;
    float count;  ///< samples that the shares add up to
};

struct FitPriors {
    uint lobes;  ///< that may have weight: the first of the mixture
    float weight;  ///< samples that each lobe is thought to have had
    float concentration;  ///< samples that are thought to have pointed everywhere
    float largest_kappa;
};

/// A lobe of less weight has nothing to explain.
const float IDLE_WEIGHT = 0.02;
/// Lobes whose directions have a larger cosine, and concentrations a smaller ratio, do the work of one.
const float TWIN_COSINE = 0.999;
const float TWIN_KAPPA_RATIO = 1.5;
const float RESEEDED_KAPPA = 10.0;
const float RESEEDED_WEIGHT = 0.1;

/// The mixture of largest posterior probability given the sums; a lobe without direction keeps the one it had. Without samples the
/// mixture stays: the BSDF may explain them all [shaders/README: Where alpha comes from].
VmfMixture fit_mixture(FitSums sums, VmfMixture before, FitPriors priors)
{
    if (!(sums.count > 0.0))
        return before;
    VmfMixture m = before;
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        m.weight[k] = k < priors.lobes ? (priors.weight + sums.share[k]) / (float(priors.lobes) * priors.weight + sums.count) : 0.0;
        vec3 r = vec3(sums.x[k], sums.y[k], sums.z[k]);
        float len = length(r);
        float effective = m.weight[k] * sums.count;
        float mean_cosine = len / max(sums.share[k], 1e-20);
        mean_cosine *= effective / max(priors.concentration + effective, 1e-20);
        m.kappa[k] = min(vmf_kappa(mean_cosine), priors.largest_kappa);
        if (len > 0.0) {
            m.x[k] = r.x / len;
            m.y[k] = r.y / len;
            m.z[k] = r.z / len;
        }
    }
    return m;
}

bool are_twins(VmfMixture m, uint i, uint j)
{
    float ratio = max(m.kappa[i], m.kappa[j]) / max(min(m.kappa[i], m.kappa[j]), 1e-20);
    return dot(lobe_direction(m, i), lobe_direction(m, j)) > TWIN_COSINE && ratio < TWIN_KAPPA_RATIO;
}

/// The one of the first `lobes` that does least, when it does nothing; GUIDING_LOBES: none.
uint find_idle_lobe(VmfMixture m, uint lobes)
{
    uint idle = GUIDING_LOBES;
    for (uint k = 0u; k < lobes; ++k) {
        bool useless = m.weight[k] < IDLE_WEIGHT;
        for (uint j = 0u; j < lobes; ++j)
            useless = useless || (j != k && m.weight[k] <= m.weight[j] && are_twins(m, k, j));
        if (useless && (idle == GUIDING_LOBES || m.weight[k] < m.weight[idle]))
            idle = k;
    }
    return idle;
}

/// The other one of the first `lobes` whose direction is closest to a lobe's.
uint nearest_lobe(VmfMixture m, uint k, uint lobes)
{
    uint nearest = GUIDING_LOBES;
    float largest_cosine = -2.0;
    for (uint j = 0u; j < lobes; ++j) {
        float cosine = dot(lobe_direction(m, j), lobe_direction(m, k));
        if (j != k && cosine > largest_cosine) {
            nearest = j;
            largest_cosine = cosine;
        }
    }
    return nearest;
}

/// Move a lobe to a direction that the others explain badly.
VmfMixture reseed_lobe(VmfMixture m, uint k, vec3 w)
{
    m.x[k] = w.x;
    m.y[k] = w.y;
    m.z[k] = w.z;
    m.kappa[k] = RESEEDED_KAPPA;
    m.weight[k] = RESEEDED_WEIGHT;
    m.weight /= dot(m.weight, vec4(1.0));
    return m;
}

#endif
