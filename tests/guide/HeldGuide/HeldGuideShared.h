// Parameters of the kernel that spoils a guide.
#ifndef HELD_GUIDE_SHARED_H
#define HELD_GUIDE_SHARED_H
#include "shaders/frame_types.h"
RESTIRPG_SHARED

struct HeldGuideParameters {
    Address frame;  ///< FrameConstants
    Address guide;  ///< of GuidingFit; its lobes are overwritten
};

RESTIRPG_SHARED_END
#endif
