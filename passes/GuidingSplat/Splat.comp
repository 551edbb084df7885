// Adds each vertex of the frame's paths to its cell: the E-step of EM against the mixture that the cell had when the paths were drawn.
// [Zeng et al. 2025, section 4.3]
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "guide/guiding_mixture.glsl"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { GuidingSplatParameters params; };

/// Not so small that its inverse would leave the fixed point's range.
const float SHORTEST_DISTANCE = 1e-3;

/// A vertex with its weight, and the direction and distance (m) that it looks to. Weight 0: not a sample.
struct Sample {
    PathVertex vertex;
    vec3 direction;
    float weight;
    float distance;
};

/// Is the BSDF one of the mixture's components [shaders/README: Where alpha comes from]? The guide says so, from its first frame on.
bool learns_alpha()
{
    return (GuidingHeaderRef(params.guide).at.options & GUIDING_ALPHA) != 0u;
}

bool is_wanted(PathVertex v)
{
    if (!is_valid(v))
        return false;
    if ((v.surface & VERTEX_FINAL) == 0u || params.finalEdges == FINAL_EDGES_ALL)
        return true;
    return params.finalEdges == FINAL_EDGES_SCATTERED && (v.surface & VERTEX_LIGHT_SAMPLED) == 0u;
}

Sample load_sample(uint index)
{
    Sample s = Sample(no_path_vertex(), vec3(0.0), 1.0, 0.0);
    if (params.samples != 0ul) {
        GuidingSample given = GuidingSampleArray(params.samples).at[index];
        s = Sample(given.vertex, vec3(0.0), given.weight, given.distance);
    } else {
        s.vertex = PathVertexArray(params.vertices).at[index];
        if (params.incident != 0u)
            s.weight = 1.0 / vertex_scatter(s.vertex);
    }
    s.direction = unpack_direction(s.vertex.direction);
    s.weight = is_wanted(s.vertex) ? min(s.weight, float(GUIDING_LARGEST_WEIGHT)) : 0.0;
    return s;
}

/// How badly a density explains a sample, as a word that grows with it.
uint strangeness(float log_density)
{
    return uint(clamp(256.0 * (128.0 - log_density), 0.0, 4294967040.0));
}

void add_distance(uint slot, Sample s, vec4 shares)
{
    GuidingDistanceSumsArray sums = guiding_distance_sums(params.statistics, params.capacity);
    for (uint k = 0u; k < GUIDING_LOBES; ++k)
        atomicAdd(sums.at[slot].lanes[k], uint64_t(to_fixed(s.weight * shares[k] / max(s.distance, SHORTEST_DISTANCE))));
}

/// The sample as it would look to the same target from another place, `offset` away.  [shaders/README: Parallax]
void look_from(inout Sample s, vec3 offset)
{
    vec3 w = s.direction - offset / max(s.distance, SHORTEST_DISTANCE);
    float len = length(w);
    if (len <= 0.0)
        return;
    s.direction = w / len;
    s.vertex.direction = pack_direction(s.direction);
    s.distance = len * max(s.distance, SHORTEST_DISTANCE);
}

void add_sample(GuidingGrid grid, Sample s)
{
    vec3 position = unpack_position(s.vertex.position);
    uint64_t key = guiding_key(grid, position, vertex_face(s.vertex), vertex_material(s.vertex));
    uint slot = insert_sample(params.statistics, params.capacity, key);
    if (slot == INVALID_INDEX)
        return;
    if (params.parallax != 0u)
        look_from(s, key_center(grid, key) - position);
    vec3 w = s.direction;
    float log_density;
    PreviousCell cell = load_previous(params.guide, grid, key);
    vec4 shares = responsibilities(cell.mixture, w, log_density);
    GuidingSumsArray sums = guiding_sums(params.statistics, params.capacity);
    if (learns_alpha()) {
        float by_bsdf = cell.alpha * vertex_density(s.vertex);
        by_bsdf /= by_bsdf + (1.0 - cell.alpha) * exp(log_density);
        atomicAdd(sums.at[slot].bsdf, uint64_t(to_fixed(s.weight * by_bsdf)));
        shares *= 1.0 - by_bsdf;
    }
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        float share = s.weight * shares[k];
        atomicAdd(sums.at[slot].lanes[4u * k], uint64_t(to_fixed(share * w.x)));
        atomicAdd(sums.at[slot].lanes[4u * k + 1u], uint64_t(to_fixed(share * w.y)));
        atomicAdd(sums.at[slot].lanes[4u * k + 2u], uint64_t(to_fixed(share * w.z)));
        atomicAdd(sums.at[slot].lanes[4u * k + 3u], uint64_t(to_fixed(share)));
    }
    atomicMax(sums.at[slot].strangest, (uint64_t(strangeness(log_density)) << 32u) | uint64_t(s.vertex.direction));
    atomicAdd(sums.at[slot].count, 1u);
    if (params.parallax != 0u)
        add_distance(slot, s, shares);
}

void main()
{
    frame = FrameRef(params.frame);
    uvec3 at = gl_GlobalInvocationID;
    bool first = at == uvec3(0u);
    at.y = at.y * params.rowStep + frame.c.frame % params.rowStep;
    if (any(greaterThanEqual(at, uvec3(frame.c.size, params.stride))))
        return;
    GuidingGrid grid = current_grid(params.cellSize, params.smallestCell);
    if (first) {
        GuidingHeaderRef(params.statistics).at.grid = grid;
        GuidingHeaderRef(params.statistics).at.capacity = params.capacity;
        GuidingHeaderRef(params.statistics).at.options = learns_alpha() ? GUIDING_ALPHA : 0u;
    }
    Sample s = load_sample(pixel_index(at.xy) * params.stride + at.z);
    if (s.weight > 0.0)
        add_sample(grid, s);
}
