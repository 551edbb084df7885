// Parameters of the kernel that makes samples up.
#ifndef KNOWN_SAMPLES_SHARED_H
#define KNOWN_SAMPLES_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct KnownSamplesParameters {
    Address frame;  ///< FrameConstants
    Address samples;  ///< GuidingSample per pixel
    uint places;
    uint identical;
};

RESTIRPG_SHARED_END
#endif
