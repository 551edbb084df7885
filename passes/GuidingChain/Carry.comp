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
    if (from >= params.capacity)
        return;
    uint64_t key = GuidingKeyArray(guiding_keys(params.history)).at[from];
    if (key == 0ul || find_slot(params.guide, params.capacity, key) != INVALID_INDEX)
        return;
    ChainCell cell = chain_cells(params.history, params.capacity).at[from];
    cell.age += 1u;
    if (cell.age > params.oldest)
        return;
    uint slot = insert_sample(params.guide, params.capacity, key);
    if (slot != INVALID_INDEX)
        chain_cells(params.guide, params.capacity).at[slot] = cell;
}
