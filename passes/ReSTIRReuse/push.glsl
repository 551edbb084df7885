// The parameters of the kernels of ReSTIRReuse.
#ifndef RESTIRPG_RESTIR_REUSE_PUSH_GLSL
#define RESTIRPG_RESTIR_REUSE_PUSH_GLSL

#include "Shared.h"

layout(push_constant, scalar) uniform Push { ReuseParameters params; };

#endif
