// Parameters of GuidingFit's kernels.
#ifndef RESTIRPG_GUIDING_FIT_SHARED_H
#define RESTIRPG_GUIDING_FIT_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/guide/guiding_grid_types.h"
RESTIRPG_SHARED

struct GuidingFitParameters {
    Address frame;  ///< FrameConstants
    Address statistics;  ///< of this frame
    Address history;  ///< the guide one frame ago
    Address guide;  ///< written
    uint capacity;  ///< slots, a power of two
    uint options;  ///< GUIDING_* flags
    uint remembers;  ///< 1: a GuidingMemory follows each cell
    uint keepsSamples;  ///< 1: a cell with too few samples keeps them for the next frame
    uint reseeds;  ///< 1: lobes that explain nothing move to the strangest sample
    uint oldest;  ///< frames that a cell guides without being fitted again
    uint lobes;  ///< that may have weight, 1 to GUIDING_LOBES
    float decay;  ///< of the sums, a frame
    float minimum;  ///< samples
    float alphaPrior;  ///< samples
    float weightPrior;
    float concentrationPrior;  ///< samples
    float largestKappa;
};

RESTIRPG_SHARED_END
#endif
