// One invocation per cell of this frame: each chain moves to what was proposed to it, or stays.  [shaders/README: Markov chain mixtures]
#version 460
#include "prelude.glsl"
#include "chain.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { GuidingChainParameters params; };

/// A number of a cell's chain in this frame, in [0, 1).
float chain_random(uint64_t key, uint chain)
{
    uint seed = (frame.c.seed ^ RANDOM_STREAM_CHAIN) + chain;
    return unit_floats(pcg4d(uvec4(uint(key), uint(key >> 32u), frame.c.frame, seed))).x;
}

/// A step of Metropolis and Hastings with independent proposals, of which the best is taken [Andrieu et al. 2010: particle independent
/// Metropolis-Hastings]: the estimates of the chain's light decide.
ChainState advance(ChainState s, uint64_t best, float energy, float u)
{
    s.energy *= params.decay;
    if (best == 0ul || energy <= 0.0 || (s.samples > 0.0 && u * s.energy >= energy))
        return s;
    uint number = uint(best);
    return move_chain(s, GuidingSampleArray(params.samples).at[number >> 1u], (number & 1u) != 0u, energy, params.memory);
}

void main()
{
    frame = FrameRef(params.frame);
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.capacity)
        return;
    uint64_t key = GuidingKeyArray(guiding_keys(params.guide)).at[slot];
    if (key == 0ul)
        return;
    ChainCell cell;
    for (uint k = 0u; k < CHAINS; ++k)
        cell.states[k] = no_chain_state();
    uint before = find_previous_slot(params.history, GuidingHeaderRef(params.guide).at.grid, key);
    if (before != INVALID_INDEX)
        cell = chain_cells(params.history, params.capacity).at[before];
    ChainProposals proposals = ChainProposalsArray(params.proposals).at[slot];
    for (uint k = 0u; k < CHAINS; ++k) {
        float energy = from_fixed(proposals.weights[k]) / float(max(proposals.count, 1u));
        cell.states[k] = advance(cell.states[k], proposals.best[k], energy, chain_random(key, k));
    }
    cell.age = 0u;
    chain_cells(params.guide, params.capacity).at[slot] = cell;
    if (has_lobe(cell))
        atomicAdd(GuidingHeaderRef(params.guide).at.guiding, 1u);
}
