// Parameters of texture_values.comp, shared by C++ and GLSL.
#ifndef RESTIRPG_TEST_TEXTURE_CASE_H
#define RESTIRPG_TEST_TEXTURE_CASE_H
#ifdef __cplusplus
#include "shaders/frame_types.h"
#else
#include "frame_types.h"
#endif
RESTIRPG_SHARED

struct TextureCase {
    Address frame;
    Address places;  ///< vec2 of each thread: where it looks
    Address values;  ///< vec4 of each thread: what it sees
    uint texture;
    uint count;
};

RESTIRPG_SHARED_END
#endif
