// Parameters of GuidingSplat's kernel.
#ifndef RESTIRPG_GUIDING_SPLAT_SHARED_H
#define RESTIRPG_GUIDING_SPLAT_SHARED_H
#include "shaders/frame_types.h"
#include "shaders/guide/guiding_grid_types.h"
RESTIRPG_SHARED

struct GuidingSplatParameters {
    Address frame;  ///< FrameConstants
    Address surface;  ///< PrimaryHit per pixel; with `paths`
    Address paths;  ///< PathReservoir per pixel; 0: `samples` are read
    Address samples;  ///< GuidingSample, stride per pixel
    Address guide;  ///< that drew the paths; in the first frame zeroed
    Address statistics;  ///< zeroed
    uint stride;  ///< samples per pixel
    uint capacity;  ///< slots, a power of two
    uint learnedBounces;  ///< of each path that are added, at most
    uint finalEdges;  ///< FINAL_EDGES_*
    uint incident;  ///< 1: weigh each vertex by 1 / (f |cos|), so that the incident radiance alone is fitted
    uint parallax;  ///< 1: turn samples to the middle of their cell and add up distances, too
    float cellSize;  ///< of the image's height
    float smallestCell;  ///< of the scene's radius
    uint rowStep;  ///< of so many rows of pixels one is added
};

// Which path edges that end on a light are added.
RESTIRPG_CONST FINAL_EDGES_ALL = 0u;
RESTIRPG_CONST FINAL_EDGES_SCATTERED = 1u;
RESTIRPG_CONST FINAL_EDGES_NONE = 2u;

RESTIRPG_SHARED_END
#endif
