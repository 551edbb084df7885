// What the kernels that test the guiding grid's samplers have in common. Compiled with GUIDED = 1 and GuidingFit's module.
#include "prelude.glsl"
#include "scene/scene.glsl"
#include "grid_guide_case.h"
#include "guide/guiding_grid.glsl"

layout(local_size_x = 64) in;

const uint CELL_MATERIAL = 3u;
const vec3 CELL_NORMAL = vec3(0.0, 0.0, 1.0);
/// Its corner is farther than a key's indices count, so that they start anew in between.
const GuidingGrid CELL_GRID = GuidingGrid(vec3(0.0, 0.0, 5.0), 0.1, vec3(-8.0 - 4096.0), 1.0 / 64.0);

/// Where guidance is asked for: in the cell, and not in its middle.
vec3 cell_position()
{
    const vec3 SOMEWHERE = vec3(0.3, 0.2, 0.1);
    uint64_t key = guiding_key(CELL_GRID, SOMEWHERE, face_of(CELL_NORMAL), CELL_MATERIAL);
    return key_center(CELL_GRID, key) + vec3(0.1, -0.08, 0.05);
}
