// The parameters of both kernels of PathTracerGuided.
#ifndef RESTIRPG_PATH_TRACER_PUSH_GLSL
#define RESTIRPG_PATH_TRACER_PUSH_GLSL

#include "Shared.h"

layout(push_constant, scalar) uniform Push { PathTracerParameters params; };

#endif
