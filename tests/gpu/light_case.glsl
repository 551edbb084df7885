// What the light test kernels have in common.
#include "scene/lights.glsl"
#include "light_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { LightCase test; };

vec4 bend(vec4 u)
{
    return test.error == ERROR_BEND ? u + 0.05 * u * (u - 1.0) : u;
}
