// A chain's state as a lobe, and how it moves.  [Alber et al. 2025; Dittebrandt et al. 2023] [shaders/README: Markov chain mixtures]
#ifndef RESTIRPG_CHAIN_GLSL
#define RESTIRPG_CHAIN_GLSL

#include "Shared.h"
#include "guide/guiding_grid.glsl"
#include "math/vmf_mixture.glsl"

layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ChainHeaderRef { ChainHeader at; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer ChainCellArray { ChainCell at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 8) buffer ChainProposalsArray { ChainProposals at[]; };

/// A path that escapes is taken to end so many radii of the scene away.
const float FAR = 100.0;

ChainCellArray chain_cells(Address guide, uint capacity)
{
    return ChainCellArray(guiding_records(guide, capacity));
}

ChainState no_chain_state()
{
    return ChainState(vec3(0.0), 0.0, 0.0, 0.0);
}

bool has_lobe(ChainCell cell)
{
    for (uint k = 0u; k < CHAINS; ++k)
        if (cell.states[k].samples > 0.0)
            return true;
    return false;
}

/// The concentration of a state's lobe, seen from a distance in m. Few samples make a wide lobe, the wider the nearer the target is.
float chain_kappa(ChainState s, float distance, float prior, float largest)
{
    float n = s.samples * s.samples;
    float r = s.cosine * n / (n + prior / max(distance * distance, 1e-12));
    return r > 0.0 ? min(vmf_kappa(r), largest) : 0.0;
}

/// The lobes of a cell's chains as they are seen from a position: of equal weight, for the chains spread by themselves in proportion to
/// the light. Is there one?
bool chain_mixture(ChainCell cell, vec3 position, float prior, float largest_kappa, out VmfMixture m)
{
    for (uint k = 0u; k < CHAINS; ++k) {
        vec3 to = cell.states[k].target - position;
        float distance = length(to);
        bool valid = cell.states[k].samples > 0.0 && distance > 0.0;
        vec3 w = valid ? to / distance : vec3(0.0, 0.0, 1.0);
        m.x[k] = w.x;
        m.y[k] = w.y;
        m.z[k] = w.z;
        m.kappa[k] = valid ? chain_kappa(cell.states[k], distance, prior, largest_kappa) : 0.0;
        m.weight[k] = valid ? 1.0 : 0.0;
    }
    float valid = dot(m.weight, vec4(1.0));
    m.weight /= max(valid, 1.0);
    return valid > 0.0;
}

/// The point that a sample met.
vec3 sample_target(GuidingSample s)
{
    return unpack_position(s.vertex.position) + min(s.distance, FAR * SCENE.radius) * unpack_direction(s.vertex.direction);
}

/// The state of a chain that has moved to a sample. `explored`: the sample is none of the present lobe's, so that a new lobe begins.
ChainState move_chain(ChainState s, GuidingSample to, bool explored, float energy, float memory)
{
    vec3 target = sample_target(to);
    if (explored || s.samples <= 0.0)
        return ChainState(target, 1.0, energy, 1.0);
    float n = min(s.samples + 1.0, memory);
    vec3 w = s.target - unpack_position(to.vertex.position);
    float cosine = dot(w, unpack_direction(to.vertex.direction)) / max(length(w), 1e-20);
    return ChainState(mix(s.target, target, 1.0 / n), mix(s.cosine, cosine, 1.0 / n), energy, n);
}

#endif
