// What the passes of the guiding grid declare alike: the knobs of its table and of its cells, and the size of a table.
#pragma once

#include "graph/interface.h"
#include "shaders/guide/guiding_grid_types.h"

#include <bit>

namespace restirpg {

/// The slots of a table. `more`: what else the pass has to say of them.
inline void cellsKnob(Interface& io, uint32_t& cells, const std::string& more = "")
{
    io.knob("cells", cells, 1u << 10, 1u << 21, "slots of the hash table, rounded up to a power of two" + more);
    io.structural();
}

inline void cellSizeKnobs(Interface& io, float& cellSize, float& smallestCell)
{
    io.knob("cell_size", cellSize, 1e-3f, 1,
            "largest side of a cell as seen in the image, as a share of the image's height");
    io.knob("smallest_cell", smallestCell, 1e-5f, 1, "smallest side of a cell, as a share of the scene's radius");
    io.structural();
}

/// The slots of a table whose knob `cells` is this.
inline uint32_t gridCapacity(uint32_t cells)
{
    return std::bit_ceil(cells);
}

/// Bytes of a table's header and keys, which begin a frame as zeros, and of records of so many bytes a slot.
inline uint64_t gridBytes(uint32_t capacity, uint64_t recordBytes = 0)
{
    return GUIDING_HEADER_BYTES + (GUIDING_KEY_BYTES + recordBytes) * capacity;
}

/// Bytes of GuidingSplat's statistics, with or without GuidingDistanceSums.
inline uint64_t gridStatisticsBytes(uint32_t capacity, bool parallax)
{
    return gridBytes(capacity, GUIDING_SUMS_BYTES + (parallax ? GUIDING_DISTANCE_SUMS_BYTES : 0));
}

}  // namespace restirpg
