// Resampling that light points and paths share. [MIS weights: shaders/README]
#ifndef RESTIRPG_RESAMPLING_GLSL
#define RESTIRPG_RESAMPLING_GLSL

/// Weighted reservoir sampling [Chao 1982]: adds an item's weight to the sum of those before it. true: the item takes the place of the
/// kept one, which happens with a chance in proportion to its weight. u: uniform in [0, 1), the item's own.
bool resample(inout float sum, float weight, float u)
{
    sum += weight;
    return u * sum < weight;
}

/// Spatial reuse, pairwise: a neighbour's share against the centre, with all neighbours' confidence on its side. Targets in one measure.
float pairwise_share(float neighbours_confidence, float there, float centre_confidence, float here)
{
    float share = neighbours_confidence * there;
    return share > 0.0 ? share / (share + centre_confidence * here) : 0.0;
}

#endif
