// Each bounce of the frame's path trees proposes its direction to one chain of its cell: to that whose lobe explains it or, where the
// BSDF explains it, to any of them.  [shaders/README: Markov chain mixtures]
#version 460
#include "prelude.glsl"
#include "chain.glsl"
#include "math/random.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GuidingChainParameters params; };

/// The lobes that the cell had when the paths were drawn.
bool previous_lobes(GuidingGrid grid, uint64_t key, vec3 position, out VmfMixture m)
{
    uint slot = find_previous_slot(params.history, grid, key);
    if (slot == INVALID_INDEX)
        return false;
    return chain_mixture(chain_cells(params.history, params.capacity).at[slot], position, params.prior, params.largestKappa, m);
}

/// The component that is thought to have drawn a sample: a lobe, or CHAINS for the BSDF. Lobes and BSDF count for a half each.
uint select_component(GuidingGrid grid, uint64_t key, GuidingSample s, float u)
{
    VmfMixture m;
    vec3 position = unpack_position(s.vertex.position);
    if (!previous_lobes(grid, key, position, m))
        return CHAINS;
    float log_density;
    m.weight = responsibilities(m, unpack_direction(s.vertex.direction), log_density);
    float density = exp(log_density);
    float by_lobes = density / (density + vertex_density(s.vertex));
    return u < by_lobes ? select_lobe(m, u / by_lobes) : CHAINS;
}

void propose(GuidingGrid grid, uint slot, uint64_t key, GuidingSample s, uint number, vec4 u)
{
    ChainProposalsArray proposals = ChainProposalsArray(params.proposals);
    atomicAdd(proposals.at[slot].count, 1u);
    float weight = s.weight * (params.product != 0u ? vertex_scatter(s.vertex) : 1.0);
    weight = min(weight, float(GUIDING_LARGEST_WEIGHT));
    if (!(weight > 0.0))
        return;
    uint component = select_component(grid, key, s, u.x);
    bool explores = component == CHAINS;
    uint chain = explores ? min(uint(u.y * float(CHAINS)), CHAINS - 1u) : component;
    atomicAdd(proposals.at[slot].weights[chain], uint64_t(to_fixed(weight)));
    // The largest bid is each sample's with a probability in proportion to its weight.
    float bid = weight / -log(max(u.z, 1e-9));
    atomicMax(proposals.at[slot].best[chain], (uint64_t(floatBitsToUint(bid)) << 32u) | uint64_t(2u * number + (explores ? 1u : 0u)));
}

void main()
{
    frame = FrameRef(params.frame);
    uvec3 at = gl_GlobalInvocationID;
    if (any(greaterThanEqual(at, uvec3(frame.c.size, params.stride))))
        return;
    GuidingGrid grid = current_grid(params.cellSize, params.smallestCell);
    ChainHeaderRef header = ChainHeaderRef(params.guide);
    if (at == uvec3(0u)) {
        header.at.table.grid = grid;
        header.at.table.capacity = params.capacity;
        header.at.spread = params.spread;
        header.at.prior = params.prior;
        header.at.largestKappa = params.largestKappa;
    }
    uint number = pixel_index(at.xy) * params.stride + at.z;
    GuidingSample s = GuidingSampleArray(params.samples).at[number];
    if (!is_valid(s.vertex))
        return;
    uint64_t key = guiding_key(grid, unpack_position(s.vertex.position), vertex_face(s.vertex), vertex_material(s.vertex));
    uint slot = insert_sample(params.guide, params.capacity, key);
    if (slot == INVALID_INDEX)
        return;
    atomicAdd(header.at.table.samples, 1u);
    RandomKey numbers = random_key(picture_pixel(at.xy), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_CHAIN);
    propose(grid, slot, key, s, number, random4(numbers, at.z, 0u));
}
