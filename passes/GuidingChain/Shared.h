// What a cell's Markov chains hold: structs of GuidingChain's kernels and of the guide's module.
#ifndef RESTIRPG_GUIDING_CHAIN_SHARED_H
#define RESTIRPG_GUIDING_CHAIN_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/guide/guiding_grid_types.h"
RESTIRPG_SHARED

/// Markov chains per cell, as many as a VmfMixture has lobes.
RESTIRPG_CONST CHAINS = 4u;

/// The state of a chain: a von Mises-Fisher lobe that is aimed at a point, so that it fits every place in the cell.
struct ChainState {
    vec3 target;  ///< mean of the points that its samples met, m, world space
    float cosine;  ///< mean cosine of their directions about that towards the target
    float energy;  ///< estimate of the chain's share of the cell's light when it last moved, decayed since
    float samples;  ///< that the means stand for; 0: there is no lobe
};

/// 100 bytes, after the keys of the guide's table.
struct ChainCell {
    ChainState states[4];
    uint age;  ///< frames since a path last met the cell
};

/// In place of the grid's GuidingHeader: the same, and how lobes are looked up.
struct ChainHeader {
    GuidingHeader table;
    float spread;  ///< of lookups: side of a square, in sides of a cell
    float prior;  ///< of the concentration, m^2
    float largestKappa;
};

/// What this frame's samples propose to the chains of a cell.
struct ChainProposals {
    /// The sample that a chain is to move to: its bid (upper half), then its number times 2, plus 1 for one that the
    /// BSDF explains. 0: none
    Address best[4];
    Address weights[4];  ///< sum of the weights of all samples that fell to the chain, fixed point
    uint count;  ///< samples in the cell, those without light, too
};

struct GuidingChainParameters {
    Address frame;  ///< FrameConstants
    Address samples;  ///< GuidingSample, `stride` per pixel
    Address history;  ///< the guide one frame ago; 0: none
    Address guide;  ///< GuidingHeader, keys, ChainCell per slot; written
    Address proposals;  ///< ChainProposals per slot of the guide
    uint stride;  ///< samples per pixel
    uint capacity;  ///< slots, a power of two
    uint product;  ///< 1: chains follow radiance times f |cos|
    uint oldest;  ///< frames that a cell guides without being met
    float cellSize;  ///< largest side of a cell, as a share of the image's height
    float smallestCell;  ///< smallest side, as a share of the scene's radius
    float spread;  ///< of lookups: side of a square, in sides of a cell
    float decay;  ///< of a state's energy, a frame
    float memory;  ///< most samples that a state's means stand for
    float prior;  ///< of the concentration, m^2
    float largestKappa;
};

RESTIRPG_SHARED_END
#endif
