// What GGX returns by single scattering, read from tables (framework/scene/energy_table.h). Compiled in only where the
// renderer's energy compensation is on.
#ifndef RESTIRPG_ENERGY_GLSL
#define RESTIRPG_ENERGY_GLSL

#include "scene/scene_types.h"

layout(buffer_reference, scalar, buffer_reference_align = 16) readonly buffer EnergyTable { vec4 at[]; };

const uint ENERGY_STRIDE = ENERGY_COLUMNS + 1u;  // a row's entries: its columns, then their mean

/// Two neighbouring rows of a table: the index of the first one's first entry, and the weight of the second.
struct EnergyRows {
    uint first;
    float weight;
};

EnergyRows energy_rows(bool inside, float roughness)
{
    float at = clamp(roughness, 0.0, 1.0) * float(ENERGY_ROWS - 1u);
    uint row = min(uint(at), ENERGY_ROWS - 2u);
    return EnergyRows(((inside ? ENERGY_ROWS : 0u) + row) * ENERGY_STRIDE, at - float(row));
}

/// An entry of energyTable at a cosine.
vec4 energy_returned(Address table, EnergyRows rows, float cosine)
{
    float at = sqrt(clamp(cosine, 0.0, 1.0)) * float(ENERGY_COLUMNS - 1u);
    uint column = min(uint(at), ENERGY_COLUMNS - 2u);
    float weight = at - float(column);
    EnergyTable entries = EnergyTable(table);
    uint low = rows.first + column, high = low + ENERGY_STRIDE;
    return mix(mix(entries.at[low], entries.at[low + 1u], weight), mix(entries.at[high], entries.at[high + 1u], weight),
               rows.weight);
}

/// Its cosine-weighted mean over the hemisphere.
vec4 energy_mean(Address table, EnergyRows rows)
{
    EnergyTable entries = EnergyTable(table);
    uint mean = rows.first + ENERGY_COLUMNS;
    return mix(entries.at[mean], entries.at[mean + ENERGY_STRIDE], rows.weight);
}

#endif
