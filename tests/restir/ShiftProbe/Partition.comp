// The MIS weights of one path, over all who could hold it, add up to 1: whichever participant it comes from. Writes the sum that is
// farthest from 1, minus 1, for paths of the pixel itself and for paths of the others, and how many of each were tried.
#version 460
#include "prelude.glsl"
#include "probe.glsl"

const uint MOST_PAIRS = 4u;
/// Of the history, as in Temporal.comp: small, so that it is often at work.
const float CAP = 4.0;

/// Who takes part: this pixel, last, and its pairs. Compilers copy a shift's code to each place that calls it, so everyone who could
/// hold a path goes through the same few lines.
ShadingPoint here;
float confidence;
uint pair_count;
ShadingPoint pair_domain[MOST_PAIRS];
PathReservoir held[MOST_PAIRS + 1u];  // by participant: its own path
float pair_confidence;  // of all pairs

void find_participants(uvec2 at, PathReservoir own)
{
    bool previous = params.way == WAY_PREVIOUS;
    pair_count = 0u;
    pair_confidence = 0.0;
    for (uint i = 0u; i < (previous ? 1u : MOST_PAIRS); ++i) {
        uint pixel;
        if (!find_pair(at, i, pixel))
            continue;
        held[pair_count] = PathReservoirArray(previous ? params.history : params.reservoirs).at[pixel];
        pair_domain[pair_count] = load_pair(pixel);
        pair_confidence += held[pair_count++].confidence;
    }
    held[pair_count] = own;
    confidence = own.confidence;
}

/// Temporal reuse: the weight of this pixel for its path y, and that of the history, which holds `source`; jacobian 0: it cannot.
float temporal_sum(PathReservoir y, float there, PathReservoir source, float jacobian)
{
    float capped = min(held[0].confidence, CAP * confidence);
    float sum = present_share(y, there, confidence, capped);
    return jacobian > 0.0 ? sum + history_share(source, y, jacobian, confidence, capped) : sum;
}

/// Spatial reuse: what pair i leaves to this pixel of its path y, and the weight of the pair, which holds `source`.
float spatial_sum(uint i, PathReservoir y, float there, PathReservoir source, float jacobian)
{
    float sum = share_left(y, there, confidence, pair_confidence);
    if (jacobian > 0.0)
        sum += neighbour_share(source, y, jacobian, confidence, pair_confidence);
    return held[i].confidence / (confidence + pair_confidence) * sum;
}

/// Sum of the weights of the path that this pixel sees as y and that `holder` holds.
float weight_sum(PathReservoir y, uint holder)
{
    bool previous = params.way == WAY_PREVIOUS;
    float sum = previous ? 0.0 : confidence / (confidence + pair_confidence);
    for (uint i = 0u; i < pair_count; ++i) {
        // First this pixel's path in the pair's domain, then the pair's path in this one. What the pair holds is the image, unless it is the
        // holder. jacobian 0: the pair could not hold it.
        PathReservoir source = y, image;
        ShadingPoint domain = pair_domain[i];
        float there = 0.0, jacobian;
        for (uint step = 0u; step < 2u; ++step) {
            if (!shift_to(source, domain, image, jacobian))
                jacobian = 0.0;
            if (step == 1u)
                break;
            there = jacobian > 0.0 ? luminance(image.f) * jacobian : 0.0;
            if (i != holder && there <= 0.0) {
                jacobian = 0.0;
                break;
            }
            source = held[i];
            if (i != holder)
                source = image;
            domain = here;
        }
        sum += previous ? temporal_sum(y, there, source, jacobian) : spatial_sum(i, y, there, source, jacobian);
    }
    return sum;
}

vec4 probe()
{
    vec4 result = vec4(0.0);
    for (uint holder = 0u; holder <= pair_count; ++holder) {
        bool own = holder == pair_count;
        PathReservoir y = held[holder];
        float jacobian;
        if (y.ucw <= 0.0 || (!own && !shift_to(held[holder], here, y, jacobian)))
            continue;
        float off = weight_sum(y, holder) - 1.0;
        if (own)
            result.x = off;
        else
            result.y = abs(off) > abs(result.y) ? off : result.y;
        result.zw += vec2(own, !own);
    }
    return result;
}

void main()
{
    uvec2 at;
    uint pixel;
    if (!begin_pixel(params.frame, at, pixel))
        return;
    Hit hit = primary_hit(params.surface, pixel);
    vec4 result = vec4(0.0);
    if (hit.instance != INVALID_INDEX) {
        here = domain_today(hit, false);
        find_participants(at, PathReservoirArray(params.reservoirs).at[pixel]);
        if (pair_count > 0u)
            result = probe();
    }
    Vec4Array(params.result).at[pixel] = result;
}
