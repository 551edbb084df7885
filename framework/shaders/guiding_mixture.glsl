// The mixture that a cell of the guiding grid had in the frame before.
#ifndef RESTIRPG_GUIDING_MIXTURE_GLSL
#define RESTIRPG_GUIDING_MIXTURE_GLSL

#include "guiding_grid.glsl"
#include "vmf_mixture.glsl"

/// That of the cell that served the place, or where a new cell starts.
VmfMixture previous_mixture(Address guide, GuidingGrid grid, uint64_t key)
{
    uint slot = find_previous_slot(guide, grid, key);
    if (slot == INVALID_INDEX)
        return new_mixture(face_normal(key_face(key)));
    return unpack_mixture(guiding_cells(guide, GuidingHeaderRef(guide).at.capacity).at[slot]);
}

#endif
