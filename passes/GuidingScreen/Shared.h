// What a pixel remembers and what it guides by: structs of GuidingScreen.comp and of the guide's module.
#ifndef RESTIRPG_GUIDING_SCREEN_SHARED_H
#define RESTIRPG_GUIDING_SCREEN_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

RESTIRPG_CONST SCREEN_LOBE_NONE = 0u;  ///< not guidable
/// In the equal-area square of the hemisphere about the normal (hemisphere_square.glsl)
RESTIRPG_CONST SCREEN_LOBE_GAUSSIAN = 1u;
RESTIRPG_CONST SCREEN_LOBE_VMF = 2u;

/// Side of the window around a pixel that its neighbours are drawn from, and how many there are, in pixels.
RESTIRPG_CONST SCREEN_WINDOW = 5u;
RESTIRPG_CONST SCREEN_NEIGHBOURS = SCREEN_WINDOW * SCREEN_WINDOW - 1u;

/// Weighted moments of the directions that a pixel has seen, smoothed over its samples. A weight is radiance over
/// density.
struct ScreenStatistics {
    vec3 first;  ///< mean of weight times (Gaussian: place z in the square, 0; vMF: world-space direction)
    vec3 second;  ///< Gaussian: mean of weight times (z_x^2, z_y^2, z_x z_y); vMF: unused
    float weight;  ///< mean weight
    float squaredWeight;  ///< mean of weight^2
    float samples;  ///< how many samples the means stand for; at most 1 / floor
};

/// A pixel's distribution of directions.
struct ScreenLobe {
    uint kind;  ///< SCREEN_LOBE_*
    vec2 mean;  ///< central direction as a place in the square
    vec3 spread;  ///< Gaussian: L11, L21, L22 of the covariance L L^T in the square; vMF: kappa, 0, 0
};

struct GuidingScreenParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel
    Address previousSurface;  ///< PrimaryHit per pixel, one frame ago
    Address motion;  ///< vec2 per pixel
    Address samples;  ///< GuidingSample, `stride` per pixel, one frame ago
    Address history;  ///< ScreenStatistics per pixel, one frame ago
    Address statistics;  ///< ScreenStatistics per pixel; 0: nobody reads it
    Address guide;  ///< ScreenLobe per pixel; 0: nobody reads it
    Address direction;  ///< vec3 per pixel; 0: nobody reads it
    Address peak;  ///< float per pixel; 0: nobody reads it
    uint stride;  ///< samples per pixel
    uint kind;  ///< SCREEN_LOBE_*
    uint product;  ///< 1: fit radiance times f |cos|
    uint neighbours;  ///< pixels around that lend their samples
    float smoothingFloor;  ///< least share of a new sample in the means
    float prior;  ///< samples' worth of a uniform hemisphere in each fit
    float regularisation;  ///< variance added to each axis, in the unit square
    float normalThreshold;  ///< least cosine between normals of pixels that share
    float depthThreshold;  ///< most relative difference of their distances from the camera
};

RESTIRPG_SHARED_END
#endif
