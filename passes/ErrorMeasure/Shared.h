// Structs shared by ErrorMeasure.cpp and ErrorMeasure.comp: see shaders/types.h.
#ifndef RESTIRPG_ERROR_MEASURE_SHARED_H
#define RESTIRPG_ERROR_MEASURE_SHARED_H
#include "shaders/math/double_single_types.h"
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

/// Sums are made by this many invocations, each over every LANES-th pixel, and then added up in their order: the same
/// bytes on every run.
RESTIRPG_CONST LANES = 1024u;

/// Sums over pixels, a channel each.
struct ErrorSums {
    DoubleSingle3 reference;
    DoubleSingle3 absolute;  ///< the terms of MAPE
    DoubleSingle3 relativeSquared;  ///< the terms of relMSE
    DoubleSingle3 squared;
    DoubleSingle3 difference;
    uint valid;  ///< pixels in the sums
};

/// The metrics of image/metrics.h, as floats. 20 bytes.
struct MeasuredErrors {
    float mape;
    float relMse;
    float rmse;
    float bias;
    uint invalid;  ///< pixels with a NaN or an infinity in either image
};

/// Push constants. An address of 0: the port is not wired.
struct ErrorMeasureParameters {
    Address frame;  ///< FrameConstants
    Address image;
    Address reference;  ///< three floats per pixel
    Address lanes;  ///< LANES ErrorSums
    Address total;  ///< ErrorSums
    Address map;
    Address errors;  ///< MeasuredErrors
};

RESTIRPG_SHARED_END
#endif
