// Structs shared by Accumulate.cpp and Accumulate.comp: see shaders/types.h.
#ifndef RESTIRPG_ACCUMULATE_SHARED_H
#define RESTIRPG_ACCUMULATE_SHARED_H
#include "shaders/math/double_single_types.h"
RESTIRPG_SHARED

/// What a pixel knows of the frames so far. 56 bytes; all zero: none.
struct AccumulatorState {
    DoubleSingle3 sum;  ///< of the values
    DoubleSingle3 deviation;  ///< sum of squared deviations from the mean
    uint count;  ///< frames in the sums
    uint invalid;  ///< frames left out
};

/// Push constants. An address of 0: the port is not wired.
struct AccumulateParameters {
    Address frame;  ///< FrameConstants
    Address direct;  ///< three images of radiance, W sr^-1 m^-2, added to one value a frame
    Address indirect;
    Address emission;
    Address history;  ///< AccumulatorState per pixel, of the frame before
    Address sums;  ///< the same, with this frame
    Address value;  ///< of this frame
    Address mean;
    Address variance;
    Address invalid;
};

RESTIRPG_SHARED_END
#endif
