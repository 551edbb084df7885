// Makes a guide of one cell.
#version 460
#include "prelude.glsl"
#include "grid_guide_case.glsl"
#include "guide/guiding_mixture.glsl"

layout(push_constant, scalar) uniform Parameters { GridGuideBuild build; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer TestLobes { TestLobe at[]; };

void main()
{
    if (gl_GlobalInvocationID.x > 0u)
        return;
    GuidingHeaderRef header = GuidingHeaderRef(build.guide);
    header.at.grid = CELL_GRID;
    header.at.capacity = TEST_CAPACITY;
    header.at.options = build.options;
    uint64_t key = guiding_key(CELL_GRID, cell_position(), face_of(CELL_NORMAL), CELL_MATERIAL);
    bool taken;
    uint probes;
    uint slot = insert_key(build.guide, TEST_CAPACITY, key, taken, probes);
    VmfMixture m;
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        TestLobe lobe = TestLobes(build.lobes).at[k];
        m.x[k] = lobe.mu.x;
        m.y[k] = lobe.mu.y;
        m.z[k] = lobe.mu.z;
        m.kappa[k] = lobe.kappa;
        m.weight[k] = lobe.weight;
    }
    guiding_cells(build.guide, TEST_CAPACITY).at[slot] = pack_mixture(m, 0.5, 0u, 1.0);
    guiding_memories(build.guide, TEST_CAPACITY).at[slot] = GuidingMemoryArray(build.memory).at[0];
}
