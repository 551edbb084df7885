// Parameters of PathVertices' kernel.
#ifndef RESTIRPG_PATH_VERTICES_SHARED_H
#define RESTIRPG_PATH_VERTICES_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct PathVerticesParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address paths;  ///< PathReservoir per pixel
    Address vertices;  ///< PathVertex, PATH_TOLD per pixel, written
};

RESTIRPG_SHARED_END
#endif
