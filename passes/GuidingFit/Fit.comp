// One invocation a cell of this frame's statistics: the M-step, into the same slot of the new guide.  [Zeng et al. 2025, section 4.4]
#version 460
#include "prelude.glsl"
#include "Shared.h"
#include "fit.glsl"
#include "guide/guiding_mixture.glsl"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Push { GuidingFitParameters params; };

/// Neither alpha nor 1 - alpha becomes less.
const float LEAST_ALPHA = 0.1;

/// The frame's sums, scaled so that the shares add up to the count of the samples: whatever unit the weights have [shaders/README: The MAP fit].
GuidingMemory load_sums(uint slot)
{
    GuidingSums s = guiding_sums(params.statistics, params.capacity).at[slot];
    GuidingMemory m;
    float total = 0.0;
    for (uint i = 0u; i < 16u; ++i)
        m.sums[i] = from_fixed(s.lanes[i]);
    for (uint k = 0u; k < GUIDING_LOBES; ++k)
        total += m.sums[4u * k + 3u];
    m.bsdf = from_fixed(s.bsdf);
    total += m.bsdf;
    m.count = total > 0.0 ? float(s.count) : 0.0;  // samples too dim for the fixed point are none
    float scale = total > 0.0 ? m.count / total : 0.0;
    for (uint i = 0u; i < 16u; ++i)
        m.sums[i] *= scale;
    m.bsdf *= scale;
    for (uint k = 0u; k < GUIDING_LOBES; ++k)
        m.inverseDistances[k] = 0.0;
    if ((params.options & GUIDING_PARALLAX) != 0u) {
        GuidingDistanceSums distances = guiding_distance_sums(params.statistics, params.capacity).at[slot];
        for (uint k = 0u; k < GUIDING_LOBES; ++k)
            m.inverseDistances[k] = from_fixed(distances.lanes[k]) * scale;
    }
    return m;
}

void add_memory(inout GuidingMemory m, GuidingMemory other, float factor)
{
    for (uint i = 0u; i < 16u; ++i)
        m.sums[i] += factor * other.sums[i];
    for (uint k = 0u; k < GUIDING_LOBES; ++k)
        m.inverseDistances[k] += factor * other.inverseDistances[k];
    m.bsdf += factor * other.bsdf;
    m.count += factor * other.count;
}

/// The sums by lobe. A cell without lobes of its own explained its samples by all of a new mixture: what fell to lobes that are not
/// to be used counts for those that are.
FitSums fit_sums(GuidingMemory m)
{
    FitSums s = FitSums(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0), m.count - m.bsdf);
    for (uint i = 0u; i < GUIDING_LOBES; ++i) {
        uint k = i % params.lobes;
        s.x[k] += m.sums[4u * i];
        s.y[k] += m.sums[4u * i + 1u];
        s.z[k] += m.sums[4u * i + 2u];
        s.share[k] += m.sums[4u * i + 3u];
    }
    return s;
}

/// What one lobe remembers goes to another. Not by index: an array that is read so is slow throughout.
void hand_over(inout GuidingMemory m, uint from, uint to)
{
    float distance = 0.0;
    vec4 moved = vec4(0.0);
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        if (k % params.lobes != from)
            continue;
        for (uint i = 0u; i < 4u; ++i) {
            moved[i] += m.sums[4u * k + i];
            m.sums[4u * k + i] = 0.0;
        }
        distance += m.inverseDistances[k];
        m.inverseDistances[k] = 0.0;
    }
    for (uint k = 0u; k < GUIDING_LOBES; ++k) {
        if (k != to)
            continue;
        for (uint i = 0u; i < 4u; ++i)
            m.sums[4u * k + i] += moved[i];
        m.inverseDistances[k] += distance;
    }
}

/// Fit the mixture to the sums. A lobe that is moved elsewhere leaves what it remembers to the one nearest to where it was: else its
/// memory would take it back.
VmfMixture fit(GuidingMemory sums, VmfMixture before, uint64_t strangest, inout GuidingMemory lasting)
{
    FitPriors priors = FitPriors(params.lobes, params.weightPrior, params.concentrationPrior, params.largestKappa);
    VmfMixture m = fit_mixture(fit_sums(sums), before, priors);
    uint idle = params.reseeds != 0u ? find_idle_lobe(m, params.lobes) : GUIDING_LOBES;
    if (idle == GUIDING_LOBES)
        return m;
    if (params.decay > 0.0 && params.lobes > 1u)
        hand_over(lasting, idle, nearest_lobe(m, idle, params.lobes));
    return reseed_lobe(m, idle, unpack_direction(uint(strangest)));
}

/// The weight of the BSDF among all components, within limits, so that neither is given up.  [shaders/README: Where alpha comes from]
float fit_alpha(GuidingMemory sums)
{
    return clamp((params.alphaPrior + sums.bsdf) / (2.0 * params.alphaPrior + sums.count), LEAST_ALPHA, 1.0 - LEAST_ALPHA);
}

/// A cell as it leaves the frame.
struct FittedCell {
    VmfMixture mixture;
    float alpha;
    uint age;  ///< frames since it was fitted
    float samples;  ///< that it was fitted to; 0: it does not guide
    GuidingMemory memory;
};

GuidingMemory times(GuidingMemory m, float factor)
{
    add_memory(m, m, factor - 1.0);
    return m;
}

/// Fit a cell to its sums, if these are enough samples; else it is what it was, until it is too old.
FittedCell refit(PreviousCell before, GuidingMemory sums, uint64_t strangest)
{
    GuidingMemory lasting = sums;
    if (sums.count >= params.minimum) {
        VmfMixture mixture = fit(sums, before.mixture, strangest, lasting);
        bool learns_alpha = (GuidingHeaderRef(params.statistics).at.options & GUIDING_ALPHA) != 0u;
        return FittedCell(mixture, learns_alpha ? fit_alpha(sums) : before.alpha, 0u, sums.count, times(lasting, params.decay));
    }
    uint age = before.slot != INVALID_INDEX ? before.age + 1u : 0u;
    float keep = params.keepsSamples != 0u ? 1.0 : params.decay;
    return FittedCell(before.mixture, before.alpha, age, age > params.oldest ? 0.0 : before.samples, times(lasting, keep));
}

void store_cell(uint slot, uint64_t key, FittedCell cell)
{
    GuidingKeyArray(guiding_keys(params.guide)).at[slot] = key;
    guiding_cells(params.guide, params.capacity).at[slot] = pack_mixture(cell.mixture, cell.alpha, cell.age, cell.samples);
    if (params.remembers != 0u)
        guiding_memories(params.guide, params.capacity).at[slot] = cell.memory;
}

void fit_cell(uint slot, uint64_t key)
{
    GuidingMemory sums = load_sums(slot);
    GuidingHeaderRef header = GuidingHeaderRef(params.guide);
    atomicAdd(header.at.cells, 1u);
    atomicAdd(header.at.samples, uint(sums.count));
    PreviousCell before = load_previous(params.history, GuidingHeaderRef(params.statistics).at.grid, key);
    if (before.slot != INVALID_INDEX && params.remembers != 0u)
        add_memory(sums, guiding_memories(params.history, params.capacity).at[before.slot], 1.0);
    if (sums.count >= params.minimum)
        atomicAdd(header.at.fitted, 1u);
    FittedCell cell = refit(before, sums, guiding_sums(params.statistics, params.capacity).at[slot].strangest);
    if (cell.samples > 0.0)
        atomicAdd(header.at.guiding, 1u);
    store_cell(slot, key, cell);
}

void main()
{
    frame = FrameRef(params.frame);
    uint slot = gl_GlobalInvocationID.x;
    if (slot >= params.capacity)
        return;
    GuidingHeader statistics = GuidingHeaderRef(params.statistics).at;
    if (slot == 0u) {
        GuidingHeaderRef header = GuidingHeaderRef(params.guide);
        header.at.grid = statistics.grid;
        header.at.capacity = params.capacity;
        header.at.options = params.options;
        header.at.collisions = statistics.collisions;
        atomicAdd(header.at.failed, statistics.failed);
    }
    uint64_t key = GuidingKeyArray(guiding_keys(params.statistics)).at[slot];
    if (key != 0ul)
        fit_cell(slot, key);
}
