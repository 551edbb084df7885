// A texture at places that the host chose.
#version 460
#extension GL_GOOGLE_include_directive : require
#include "scene/texture.glsl"
#include "texture_case.h"

layout(local_size_x = 64) in;
layout(push_constant, scalar) uniform Parameters { TextureCase test; };
layout(buffer_reference, scalar, buffer_reference_align = 4) readonly buffer PlaceArray { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) writeonly buffer ValueArray { vec4 at[]; };

void main()
{
    frame = FrameRef(test.frame);
    uint index = gl_GlobalInvocationID.x;
    if (index < test.count)
        ValueArray(test.values).at[index] = sample_texture(test.texture, PlaceArray(test.places).at[index]);
}
