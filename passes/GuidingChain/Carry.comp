// One invocation per cell of the previous guide: cells that no path has met in this frame go on guiding for a while.
#version 460
#include "prelude.glsl"
#include "chain.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { GuidingChainParameters params; };

void main()
{
    frame = FrameRef(params.frame);
    uint from = gl_GlobalInvocationID.x;
    uint64_t key = key_to_carry(params.history, params.guide, params.capacity, from);
    if (key == 0ul)
        return;
    ChainCell cell = chain_cells(params.history, params.capacity).at[from];
    cell.age += 1u;
    if (cell.age > params.oldest)
        return;
    uint slot = insert_carried(params.guide, params.capacity, key, has_lobe(cell));
    if (slot != INVALID_INDEX)
        chain_cells(params.guide, params.capacity).at[slot] = cell;
}
