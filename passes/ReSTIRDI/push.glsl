// The parameters of all kernels of ReSTIRDI.
#ifndef RESTIRPG_RESTIR_DI_PUSH_GLSL
#define RESTIRPG_RESTIR_DI_PUSH_GLSL

#include "Shared.h"

layout(push_constant, scalar) uniform Push { ReSTIRDIParameters params; };

#endif
