// One invocation a cell of the previous guide: cells that no path has touched in this frame go on guiding for a while.
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "guide/guiding_mixture.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { GuidingFitParameters params; };

void main()
{
    frame = FrameRef(params.frame);
    uint from = gl_GlobalInvocationID.x;
    uint64_t key = key_to_carry(params.history, params.guide, params.capacity, from);
    if (key == 0ul)
        return;
    GuidingCell cell = guiding_cells(params.history, params.capacity).at[from];
    cell.state += 1u;
    if (cell_age(cell) > params.oldest)
        return;
    uint slot = insert_carried(params.guide, params.capacity, key, cell.samples > 0.0);
    if (slot == INVALID_INDEX)
        return;
    guiding_cells(params.guide, params.capacity).at[slot] = cell;
    if (params.remembers != 0u)
        guiding_memories(params.guide, params.capacity).at[slot] = guiding_memories(params.history, params.capacity).at[from];
}
