#version 460
#include "scene/scene.glsl"
#include "Shared.h"

layout(local_size_x = 8, local_size_y = 8) in;
layout(push_constant, scalar) uniform Push { ExposureParams params; };

void main()
{
    uvec2 pixel = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(pixel, params.size)))
        return;
    uint index = pixel.y * params.size.x + pixel.x;
    Vec3Image(params.image).at[index] = params.scale * Vec3Image(params.radiance).at[index];
}
