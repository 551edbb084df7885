// The mixture that a cell of the guiding grid had in the frame before.
#ifndef RESTIRPG_GUIDING_MIXTURE_GLSL
#define RESTIRPG_GUIDING_MIXTURE_GLSL

#include "guiding_grid.glsl"
#include "math/vmf_mixture.glsl"

/// Probability of the BSDF where nothing has been learnt.
const float NEW_ALPHA = 0.5;

/// That of the cell that served the place, or where a new cell starts; with its probability of the BSDF.
VmfMixture previous_mixture(Address guide, GuidingGrid grid, uint64_t key, out float alpha)
{
    uint slot = find_previous_slot(guide, grid, key);
    alpha = NEW_ALPHA;
    if (slot == INVALID_INDEX)
        return new_mixture(face_normal(key_face(key)));
    GuidingCell cell = guiding_cells(guide, GuidingHeaderRef(guide).at.capacity).at[slot];
    alpha = cell_alpha(cell);
    return unpack_mixture(cell);
}

#endif
