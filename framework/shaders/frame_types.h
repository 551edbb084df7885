// What every kernel knows of the frame it works on. Shared by C++ and GLSL: see types.h.
#ifndef RESTIRPG_FRAME_TYPES_H
#define RESTIRPG_FRAME_TYPES_H
#include "shaders/scene/scene_types.h"
RESTIRPG_SHARED

struct FrameConstants {
    SceneTable scene;
    Camera camera;
    Camera previousCamera;
    uvec2 size;  ///< pixels that are rendered: those of the window
    uvec2 corner;  ///< the window's first pixel in the whole picture
    uvec2 picture;  ///< pixels of the whole picture, which the camera sees
    uint frame;  ///< frames since the last cut
    uint seed;  ///< of the run
    uint reset;  ///< 1 on the first frame after a start or a cut: history is empty
    /// 1: SceneTable::center or radius is not the frame before's, in whose cube the history's positions are packed
    uint rescaled;
    float time;  ///< seconds, of the scene's animation
};

RESTIRPG_SHARED_END
#endif
