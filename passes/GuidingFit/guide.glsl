// The functions of shaders/guide/guide.glsl for GuidingFit's guide: a mixture of von Mises-Fisher lobes in each cell of the grid.
#include "guide/guiding_mixture.glsl"

struct Guide {
    PlacedMixture lobes;
    float alpha;  ///< what the cell has learnt, or below 0
};

/// Concentration of the lobe that resembles the cosine about a normal.
const float COSINE_KAPPA = 2.18853;

/// Each lobe times the cosine about the normal, normalised together: the product of two vMFs is one [shaders/README: The von Mises-Fisher distribution].
void multiply_by_cosine(inout VmfMixture m, vec3 normal)
{
    float cosine_normalization = vmf_normalization(COSINE_KAPPA);
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        vec3 axis = m.kappa[k] * lobe_direction(m, k) + COSINE_KAPPA * normal;
        float kappa = length(axis);
        m.weight[k] *= vmf_normalization(m.kappa[k]) * cosine_normalization / vmf_normalization(kappa) *
                       exp(kappa - m.kappa[k] - COSINE_KAPPA);
        axis = kappa > 0.0 ? axis / kappa : normal;
        m.x[k] = axis.x;
        m.y[k] = axis.y;
        m.z[k] = axis.z;
        m.kappa[k] = kappa;
    }
    m.weight /= max(dot(m.weight, vec4(1.0)), 1e-30);
}

/// Aim each lobe from where it is asked for at what it was fitted to, seen from the cell's centre.  [shaders/README: Parallax]
void aim_lobes(inout VmfMixture m, GuidingMemory memory, vec3 center, vec3 position)
{
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        float inverse = memory.inverseDistances[k] / max(memory.sums[4u * k + 3u], 1e-20);
        vec3 axis = lobe_direction(m, k) + (center - position) * inverse;
        float len = length(axis);
        if (len <= 0.0)
            continue;
        m.x[k] = axis.x / len;
        m.y[k] = axis.y / len;
        m.z[k] = axis.z / len;
    }
}

bool guide_lookup(Address guide, GuideQuery query, out Guide g)
{
    GuidingHeader header = GuidingHeaderRef(guide).at;
    if (header.capacity == 0u)
        return false;
    uint64_t key = guiding_key(header.grid, query.position, face_of(query.normal), query.material);
    uint slot = find_slot(guide, header.capacity, key);
    if (slot == INVALID_INDEX)
        return false;
    GuidingCell cell = guiding_cells(guide, header.capacity).at[slot];
    if (cell.samples <= 0.0)
        return false;
    VmfMixture m = unpack_mixture(cell);
    if ((header.options & GUIDING_PARALLAX) != 0u)
        aim_lobes(m, guiding_memories(guide, header.capacity).at[slot], key_center(header.grid, key), query.position);
    if ((header.options & GUIDING_COSINE) != 0u)
        multiply_by_cosine(m, query.normal);
    g.lobes = place_mixture(m);
    g.alpha = (header.options & GUIDING_ALPHA) != 0u ? cell_alpha(cell) : -1.0;
    return true;
}

vec3 guide_sample(Guide g, vec3 u)
{
    return sample_mixture(g.lobes, u);
}

float guide_pdf(Guide g, vec3 w)
{
    return mixture_pdf(g.lobes, w);
}

float guide_alpha(Guide g, float alpha)
{
    return g.alpha < 0.0 ? alpha : g.alpha;
}
