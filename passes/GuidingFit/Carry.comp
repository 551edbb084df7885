// One invocation a cell of the previous guide: cells that no path has touched in this frame go on guiding for a while.
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "guide/guiding_grid.glsl"
#include "math/vmf_mixture.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { GuidingFitParameters params; };

void carry_cell(uint64_t key, uint from)
{
    GuidingCell cell = guiding_cells(params.history, params.capacity).at[from];
    cell.state += 1u;
    if (cell_age(cell) > params.oldest || find_slot(params.guide, params.capacity, key) != INVALID_INDEX)
        return;
    GuidingHeaderRef header = GuidingHeaderRef(params.guide);
    bool taken;
    uint probes;
    uint slot = insert_key(params.guide, params.capacity, key, taken, probes);
    if (slot == INVALID_INDEX) {
        atomicAdd(header.at.failed, 1u);
        return;
    }
    guiding_cells(params.guide, params.capacity).at[slot] = cell;
    if (params.remembers != 0u)
        guiding_memories(params.guide, params.capacity).at[slot] = guiding_memories(params.history, params.capacity).at[from];
    atomicAdd(header.at.cells, 1u);
    if (cell.samples > 0.0)
        atomicAdd(header.at.guiding, 1u);
}

void main()
{
    frame = FrameRef(params.frame);
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.capacity || !same_places(GuidingHeaderRef(params.history).at.grid, GuidingHeaderRef(params.guide).at.grid))
        return;
    uint64_t key = GuidingKeyArray(guiding_keys(params.history)).at[slot];
    if (key != 0ul)
        carry_cell(key, slot);
}
