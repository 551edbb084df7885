// Parameters of GBuffer.comp. Outputs that nobody reads have address 0.
#ifndef RESTIRPG_GBUFFER_SHARED_H
#define RESTIRPG_GBUFFER_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct GBufferParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address emission;  ///< vec3 per pixel
    Address normal;  ///< vec3 per pixel
    Address geometricNormal;  ///< vec3 per pixel
    Address albedo;  ///< vec3 per pixel
    Address depth;  ///< float per pixel
    Address motion;  ///< vec2 per pixel
    Address material;  ///< float per pixel
    uint jitter;  ///< 1: a uniform point of the pixel, 0: its centre
};

RESTIRPG_SHARED_END
#endif
