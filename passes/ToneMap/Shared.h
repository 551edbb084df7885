// Parameters of ToneMap.comp.
#ifndef RESTIRPG_TONE_MAP_SHARED_H
#define RESTIRPG_TONE_MAP_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct ToneMapParameters {
    Address frame;  ///< FrameConstants
    Address image;  ///< vec3 per pixel, linear Rec.709
    Address display;  ///< vec3 per pixel, written
    float gain;  ///< factor of the exposure
    float white;  ///< luminance after exposure that becomes 1; Reinhard's curve only
    uint curve;  ///< TONE_CURVE_*
};

RESTIRPG_CONST TONE_CURVE_LINEAR = 0u;
RESTIRPG_CONST TONE_CURVE_REINHARD = 1u;

RESTIRPG_SHARED_END
#endif
