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
    if (from >= params.capacity || !same_places(GuidingHeaderRef(params.history).at.grid, GuidingHeaderRef(params.guide).at.grid))
        return;
    uint64_t key = GuidingKeyArray(guiding_keys(params.history)).at[from];
    if (key == 0ul || find_slot(params.guide, params.capacity, key) != INVALID_INDEX)
        return;
    ChainCell cell = chain_cells(params.history, params.capacity).at[from];
    cell.age += 1u;
    if (cell.age > params.oldest)
        return;
    GuidingHeaderRef header = GuidingHeaderRef(params.guide);
    bool taken;
    uint probes;
    uint slot = insert_key(params.guide, params.capacity, key, taken, probes);
    if (slot == INVALID_INDEX) {
        atomicAdd(header.at.failed, 1u);
        return;
    }
    chain_cells(params.guide, params.capacity).at[slot] = cell;
    atomicAdd(header.at.cells, 1u);
    if (has_lobe(cell))
        atomicAdd(header.at.guiding, 1u);
}
