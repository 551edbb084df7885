// The functions of shaders/guide/guide.glsl for GuidingChain's guide: the lobes of a cell's Markov chains.
#include "chain.glsl"
#include "math/random.glsl"

#define Guide PlacedMixture

/// A place near the query's, within its surface's plane: cells have no visible borders then, and each pixel sees the chains of all
/// cells around. The same for every lookup of a bounce.
vec3 spread_position(GuidingGrid grid, GuideQuery query, float spread)
{
    RandomKey numbers = random_key(picture_pixel(query.pixel), frame.c.frame, frame.c.seed ^ RANDOM_STREAM_CHAIN_LOOKUP);
    vec2 u = random2(numbers, query.bounce, 0u) - 0.5;
    float side = spread * cell_side(grid, cell_level(grid, query.position));
    return query.position + to_world(make_frame(query.normal), vec3(side * u, 0.0));
}

bool guide_lookup(Address guide, GuideQuery query, out Guide g)
{
    ChainHeader header = ChainHeaderRef(guide).at;
    uint capacity = header.table.capacity;
    if (capacity == 0u)
        return false;
    uint face = face_of(query.normal);
    vec3 near = spread_position(header.table.grid, query, header.spread);
    uint slot = find_slot(guide, capacity, guiding_key(header.table.grid, near, face, query.material));
    if (slot == INVALID_INDEX)
        slot = find_slot(guide, capacity, guiding_key(header.table.grid, query.position, face, query.material));
    VmfMixture m;
    if (slot == INVALID_INDEX ||
        !chain_mixture(chain_cells(guide, capacity).at[slot], query.position, header.prior, header.largestKappa, m))
        return false;
    g = place_mixture(m);
    return true;
}

vec3 guide_sample(Guide g, vec3 u)
{
    return sample_mixture(g, u);
}

float guide_pdf(Guide g, vec3 w)
{
    return mixture_pdf(g, w);
}

float guide_alpha(Guide g, float alpha)
{
    return alpha;
}
