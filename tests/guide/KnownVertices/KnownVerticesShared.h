// Parameters of the kernel that makes vertices up.
#ifndef KNOWN_VERTICES_SHARED_H
#define KNOWN_VERTICES_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct KnownVerticesParameters {
    Address frame;  ///< FrameConstants
    Address vertices;  ///< PathVertex per pixel
    uint places;
    uint identical;
};

RESTIRPG_SHARED_END
#endif
