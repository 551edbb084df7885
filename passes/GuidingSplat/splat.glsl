// Adding samples to their cells: the E-step of EM against the mixture that the cell had when the paths were drawn.
// [Zeng et al. 2025, section 4.3]
#ifndef RESTIRPG_GUIDING_SPLAT_GLSL
#define RESTIRPG_GUIDING_SPLAT_GLSL

#include "Shared.h"
#include "guide/guiding_mixture.glsl"

layout(push_constant, scalar) uniform Push { GuidingSplatParameters params; };

/// Distances below it count as it, so that inverse distances are at most 1000.
const float SHORTEST_DISTANCE = 1e-3;

/// A vertex with its weight, and the direction and distance (m) that it looks to.
struct Sample {
    PathVertex vertex;
    vec3 direction;
    float weight;
    float distance;
};

Sample make_sample(PathVertex v, float weight, float distance)
{
    return Sample(v, unpack_direction(v.direction), min(weight, float(GUIDING_LARGEST_WEIGHT)), distance);
}

/// Is the BSDF one of the mixture's components [shaders/README: Where alpha comes from]? The guide says so, from its first frame on.
bool learns_alpha()
{
    return (GuidingHeaderRef(params.guide).at.options & GUIDING_ALPHA) != 0u;
}

/// How badly a density explains a sample, as a word that grows with it.
uint strangeness(float log_density)
{
    return uint(clamp(256.0 * (128.0 - log_density), 0.0, 4294967040.0));
}

void add_distance(uint slot, Sample s, vec4 shares)
{
    GuidingDistanceSumsArray sums = guiding_distance_sums(params.statistics, params.capacity);
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        float weight = min(s.weight * shares[k] / max(s.distance, SHORTEST_DISTANCE), float(GUIDING_LARGEST_WEIGHT));
        atomicAdd(sums.at[slot].lanes[k], uint64_t(to_fixed(weight)));
    }
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

/// First thing in main: sets `frame`, and finds the pixel of the invocation among the rows that are added in this frame; false: there is
/// none. One invocation notes in the table what its keys mean.
bool begin_splat(out uvec2 at, out GuidingGrid grid)
{
    frame = FrameRef(params.frame);
    at = gl_GlobalInvocationID.xy;
    at.y = at.y * params.rowStep + frame.c.frame % params.rowStep;
    grid = current_grid(params.cellSize, params.smallestCell);
    if (gl_GlobalInvocationID == uvec3(0u)) {
        GuidingHeaderRef(params.statistics).at.grid = grid;
        GuidingHeaderRef(params.statistics).at.capacity = params.capacity;
        GuidingHeaderRef(params.statistics).at.options = learns_alpha() ? GUIDING_ALPHA : 0u;
    }
    return all(lessThan(at, frame.c.size));
}

#endif
