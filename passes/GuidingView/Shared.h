// Parameters of GuidingView's kernel.
#ifndef RESTIRPG_GUIDING_VIEW_SHARED_H
#define RESTIRPG_GUIDING_VIEW_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/guide/guiding_grid_types.h"
RESTIRPG_SHARED

struct GuidingViewParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address guide;  ///< of GuidingFit
    Address image;  ///< vec3 per pixel; written
    uint show;  ///< VIEW_*
};

// What is shown.
RESTIRPG_CONST VIEW_CELL = 0u;
RESTIRPG_CONST VIEW_LEVEL = 1u;
RESTIRPG_CONST VIEW_SAMPLES = 2u;
RESTIRPG_CONST VIEW_AGE = 3u;
RESTIRPG_CONST VIEW_KAPPA = 4u;
RESTIRPG_CONST VIEW_WEIGHT = 5u;
RESTIRPG_CONST VIEW_GUIDED = 6u;

RESTIRPG_SHARED_END
#endif
