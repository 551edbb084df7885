// The mixture of a cell of the guiding grid: as it is stored, and as it was in the frame before.
#ifndef RESTIRPG_GUIDING_MIXTURE_GLSL
#define RESTIRPG_GUIDING_MIXTURE_GLSL

#include "guiding_grid.glsl"
#include "math/vmf_mixture.glsl"

VmfMixture unpack_mixture(GuidingCell cell)
{
    VmfMixture m;
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        vec3 w = unpack_direction(cell.lobes[k].direction);
        m.x[k] = w.x;
        m.y[k] = w.y;
        m.z[k] = w.z;
        m.kappa[k] = cell.lobes[k].kappa;
        m.weight[k] = cell.lobes[k].weight;
    }
    return m;
}

/// alpha: probability of the BSDF instead of the mixture.
GuidingCell pack_mixture(VmfMixture m, float alpha, uint age, float samples)
{
    GuidingCell cell;
    for (uint k = 0u; k < GUIDING_LOBES; ++k)
        cell.lobes[k] = GuidingLobe(pack_direction(lobe_direction(m, k)), m.kappa[k], m.weight[k]);
    cell.state = min(age, 0xffffu) | (packUnorm2x16(vec2(0.0, alpha)) & 0xffff0000u);
    cell.samples = samples;
    return cell;
}

/// Frames since the cell was last fitted.
uint cell_age(GuidingCell cell)
{
    return cell.state & 0xffffu;
}

/// Probability of the BSDF that the cell has learnt, with GUIDING_ALPHA.
float cell_alpha(GuidingCell cell)
{
    return unpackUnorm2x16(cell.state).y;
}

/// Probability of the BSDF where nothing has been learnt.
const float NEW_ALPHA = 0.5;

/// What served a cell's place in the frame before.
struct PreviousCell {
    uint slot;  ///< INVALID_INDEX: none did, and the rest is where a new cell starts
    VmfMixture mixture;
    float alpha;  ///< probability of the BSDF
    uint age;  ///< frames since it was fitted, at that frame's end
    float samples;  ///< that it was fitted to
};

PreviousCell load_previous(Address guide, GuidingGrid grid, uint64_t key)
{
    uint slot = find_previous_slot(guide, grid, key);
    if (slot == INVALID_INDEX)
        return PreviousCell(slot, new_mixture(face_normal(key_face(key))), NEW_ALPHA, 0u, 0.0);
    GuidingCell cell = guiding_cells(guide, GuidingHeaderRef(guide).at.capacity).at[slot];
    return PreviousCell(slot, unpack_mixture(cell), cell_alpha(cell), cell_age(cell), cell.samples);
}

#endif
