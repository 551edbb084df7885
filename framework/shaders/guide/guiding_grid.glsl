// Keys, lookup and insertion of the guiding grid. A key is a view-adaptive cell, its level, the face of the surface's normal and the
// material (the BSDF ID).  [Zeng et al. 2025, section 4.3; Pantaleoni 2020]
#ifndef RESTIRPG_GUIDING_GRID_GLSL
#define RESTIRPG_GUIDING_GRID_GLSL

#include "guiding_grid_types.h"
#include "restir/path_vertex.glsl"
#include "math/random.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer GuidingHeaderRef { GuidingHeader at; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer GuidingKeyArray { uint64_t at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer GuidingSumsArray { GuidingSums at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer GuidingDistanceSumsArray { GuidingDistanceSums at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer GuidingCellArray { GuidingCell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer GuidingMemoryArray { GuidingMemory at[]; };

Address guiding_keys(Address table)
{
    return table + GUIDING_HEADER_BYTES;
}

Address guiding_records(Address table, uint capacity)
{
    return guiding_keys(table) + uint64_t(GUIDING_KEY_BYTES) * capacity;
}

GuidingSumsArray guiding_sums(Address statistics, uint capacity)
{
    return GuidingSumsArray(guiding_records(statistics, capacity));
}

GuidingDistanceSumsArray guiding_distance_sums(Address statistics, uint capacity)
{
    return GuidingDistanceSumsArray(guiding_records(statistics, capacity) + uint64_t(GUIDING_SUMS_BYTES) * capacity);
}

GuidingCellArray guiding_cells(Address guide, uint capacity)
{
    return GuidingCellArray(guiding_records(guide, capacity));
}

GuidingMemoryArray guiding_memories(Address guide, uint capacity)
{
    return GuidingMemoryArray(guiding_records(guide, capacity) + uint64_t(GUIDING_CELL_BYTES) * capacity);
}

/// A sum's summand in fixed point [shaders/README: Fixed point], and back.
int64_t to_fixed(float x)
{
    return int64_t(round(x * float(1u << GUIDING_FRACTION_BITS)));
}

float from_fixed(uint64_t lane)
{
    return float(int64_t(lane)) * (1.0 / float(1u << GUIDING_FRACTION_BITS));
}

/// The grid of this frame. `cell_size`: of a cell, as a share of the image's height; `smallest_cell`: of the scene's radius.
GuidingGrid current_grid(float cell_size, float smallest_cell)
{
    GuidingGrid grid;
    grid.camera = frame.c.camera.position;
    grid.scale = cell_size * 2.0 * length(frame.c.camera.up);
    grid.smallest = smallest_cell * SCENE.radius;
    // Not the cube's corner itself: a sheet through the middle of the scene would lie on borders of cells, and samples, whose positions
    // are packed, would fall to its other side.
    grid.origin = position_cube().xyz - 0.382 * grid.smallest;
    return grid;
}

/// Side of the cells of a level, m.
float cell_side(GuidingGrid grid, uint level)
{
    return grid.smallest * float(1u << level);
}

/// The level that suits a place: its cells are at most as large as asked for there.
uint cell_level(GuidingGrid grid, vec3 position)
{
    float side = grid.scale * distance(position, grid.camera);
    return uint(clamp(floor(log2(side / grid.smallest)), 0.0, 31.0));
}

uint64_t guiding_key(GuidingGrid grid, vec3 position, uint face, uint material)
{
    uint level = cell_level(grid, position);
    uint mask = (1u << GUIDING_INDEX_BITS) - 1u;
    uvec3 index = uvec3(max((position - grid.origin) / cell_side(grid, level), vec3(0.0))) & mask;
    return uint64_t(index.x) | (uint64_t(index.y) << GUIDING_INDEX_BITS) | (uint64_t(index.z) << (2u * GUIDING_INDEX_BITS)) |
           (uint64_t(level) << GUIDING_LEVEL_SHIFT) | (uint64_t(face) << GUIDING_FACE_SHIFT) |
           (uint64_t(material & 0xffffu) << GUIDING_MATERIAL_SHIFT) | (1ul << 63u);
}

uint key_level(uint64_t key)
{
    return uint(key >> GUIDING_LEVEL_SHIFT) & 31u;
}

uint key_face(uint64_t key)
{
    return uint(key >> GUIDING_FACE_SHIFT) & 7u;
}

uint key_material(uint64_t key)
{
    return uint(key >> GUIDING_MATERIAL_SHIFT) & 0xffffu;
}

/// The middle of a key's cell. A fine level has more cells than its indices count, so that they start anew every 2^GUIDING_INDEX_BITS cells:
/// of the cells of one key it is the nearest to the camera, which is where that level serves.
vec3 key_center(GuidingGrid grid, uint64_t key)
{
    uint mask = (1u << GUIDING_INDEX_BITS) - 1u;
    uvec3 index = uvec3(uint(key), uint(key >> GUIDING_INDEX_BITS), uint(key >> (2u * GUIDING_INDEX_BITS))) & mask;
    float side = cell_side(grid, key_level(key)), period = float(mask) + 1.0;
    vec3 turns = round(((grid.camera - grid.origin) / side - vec3(index)) / period);
    return grid.origin + (vec3(index) + max(turns, vec3(0.0)) * period + 0.5) * side;
}

uint key_slot(uint64_t key, uint capacity)
{
    // The lower bits of pcg4d do not depend on the upper bits of its input: cells would crowd. Fold the upper ones in.
    uint hash = pcg4d(uvec4(uint(key), uint(key >> 32u), 0u, 0u)).x;
    return (hash ^ (hash >> 16u)) & (capacity - 1u);
}

/// The slot of a key; INVALID_INDEX: it is not in the table.
uint find_slot(Address table, uint capacity, uint64_t key)
{
    GuidingKeyArray keys = GuidingKeyArray(guiding_keys(table));
    uint slot = key_slot(key, capacity);
    for (uint i = 0u; i < GUIDING_PROBES; ++i) {
        uint64_t there = keys.at[slot];
        if (there == key)
            return slot;
        if (there == 0ul)
            return INVALID_INDEX;
        slot = (slot + 1u) & (capacity - 1u);
    }
    return INVALID_INDEX;
}

/// Do keys mean the same places in both? They do unless the scene has outgrown its sphere, or has shrunk.
bool same_places(GuidingGrid a, GuidingGrid b)
{
    return a.origin == b.origin && a.smallest == b.smallest;
}

/// The slot that served a cell in the frame before: by the cell's own key or, when the camera has moved, the level's border lies there or
/// keys mean other places now, the key that its middle had. INVALID_INDEX: none.
uint find_previous_slot(Address guide, GuidingGrid grid, uint64_t key)
{
    if (guide == 0ul)
        return INVALID_INDEX;
    GuidingHeader header = GuidingHeaderRef(guide).at;
    if (header.capacity == 0u)
        return INVALID_INDEX;
    if (same_places(header.grid, grid)) {
        uint slot = find_slot(guide, header.capacity, key);
        if (slot != INVALID_INDEX)
            return slot;
    }
    return find_slot(guide, header.capacity, guiding_key(header.grid, key_center(grid, key), key_face(key), key_material(key)));
}

/// The slot of a key, taken if need be; INVALID_INDEX: there was none. `taken`: this call has taken it; `probes`: slots of other keys met.
uint insert_key(Address table, uint capacity, uint64_t key, out bool taken, out uint probes)
{
    GuidingKeyArray keys = GuidingKeyArray(guiding_keys(table));
    uint slot = key_slot(key, capacity);
    taken = false;
    for (probes = 0u; probes < GUIDING_PROBES; ++probes) {
        uint64_t there = keys.at[slot];
        if (there == 0ul) {
            there = atomicCompSwap(keys.at[slot], 0ul, key);
            taken = there == 0ul;
        }
        if (taken || there == key)
            return slot;
        slot = (slot + 1u) & (capacity - 1u);
    }
    return INVALID_INDEX;
}

/// insert_key for a sample, with the counts of the table's header.
uint insert_sample(Address table, uint capacity, uint64_t key)
{
    GuidingHeaderRef header = GuidingHeaderRef(table);
    bool taken;
    uint probes;
    uint slot = insert_key(table, capacity, key, taken, probes);
    if (probes > 0u)
        atomicAdd(header.at.collisions, probes);
    if (taken)
        atomicAdd(header.at.cells, 1u);
    if (slot == INVALID_INDEX)
        atomicAdd(header.at.failed, 1u);
    return slot;
}

/// The key in slot `from` of the guide of the frame before, if its cell is to be carried into this frame's: it means the same place now,
/// and no path has met the cell. Else 0.
uint64_t key_to_carry(Address history, Address guide, uint capacity, uint from)
{
    if (from >= capacity || !same_places(GuidingHeaderRef(history).at.grid, GuidingHeaderRef(guide).at.grid))
        return 0ul;
    uint64_t key = GuidingKeyArray(guiding_keys(history)).at[from];
    return key != 0ul && find_slot(guide, capacity, key) == INVALID_INDEX ? key : 0ul;
}

/// A slot for a cell that is carried on, with the counts of the guide's header; INVALID_INDEX: there was none.
uint insert_carried(Address guide, uint capacity, uint64_t key, bool guides)
{
    GuidingHeaderRef header = GuidingHeaderRef(guide);
    bool taken;
    uint probes;
    uint slot = insert_key(guide, capacity, key, taken, probes);
    if (slot == INVALID_INDEX) {
        atomicAdd(header.at.failed, 1u);
        return slot;
    }
    atomicAdd(header.at.cells, 1u);
    if (guides)
        atomicAdd(header.at.guiding, 1u);
    return slot;
}

#endif
