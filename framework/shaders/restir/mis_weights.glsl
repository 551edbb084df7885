// MIS weights that the resampling of light points and that of paths share [shaders/README: MIS weights].
#ifndef RESTIRPG_MIS_WEIGHTS_GLSL
#define RESTIRPG_MIS_WEIGHTS_GLSL

/// Spatial reuse, pairwise: a neighbour's share against the centre, with all neighbours' confidence on its side. Targets in one measure.
float pairwise_share(float neighbours_confidence, float there, float centre_confidence, float here)
{
    float share = neighbours_confidence * there;
    return share > 0.0 ? share / (share + centre_confidence * here) : 0.0;
}

#endif
