// Parameters of the kernels that test GuidingScreen's lobes, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_SCREEN_LOBE_CASE_H
#define RESTIRPG_TEST_SCREEN_LOBE_CASE_H
#include "../../passes/GuidingScreen/Shared.h"
#include "../gpu/bsdf_case.h"
RESTIRPG_SHARED

struct LobeCase {
    Address frame;  ///< FrameConstants; only the size counts
    Address guide;  ///< one ScreenLobe
    Address results;  ///< what the kernel writes
    vec3 normal;  ///< of the surface
    /// Half the side of the window of bins about the lobe's centre, as a sine; 0: bins of the whole sphere
    float zoom;
    uint seed;
    uint error;  ///< ERROR_NONE, ERROR_BEND or ERROR_PDF
};

/// What screen_lobe_sample.comp counts.
struct LobeCounts {
    uint bins[BINS];
    uint lost;  ///< draws without a direction, or outside of the window
};

struct FitSample {
    vec3 direction;
    float weight;
};

struct FitCase {
    Address samples;  ///< FitSample
    Address results;  ///< one ScreenLobe
    vec3 normal;  ///< of the surface
    uint count;
    uint kind;  ///< SCREEN_LOBE_*
    float smoothingFloor;
    float prior;
    float regularisation;
};

RESTIRPG_SHARED_END
#endif
