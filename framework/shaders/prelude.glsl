// The extensions every kernel uses and the frame it works on. Include it first, after #version.
#ifndef RESTIRPG_PRELUDE_GLSL
#define RESTIRPG_PRELUDE_GLSL

#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_buffer_reference : require
#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require
#extension GL_EXT_shader_atomic_int64 : require
#extension GL_EXT_control_flow_attributes : require
#extension GL_EXT_null_initializer : require

#include "frame_types.h"

layout(buffer_reference, scalar, buffer_reference_align = 8) readonly buffer FrameRef { FrameConstants c; };

/// Set first thing in main: by begin_pixel, or `frame = FrameRef(params.frame)`.
FrameRef frame;

#define SCENE frame.c.scene

const float PI = 3.14159265358979;
const float INV_PI = 0.31830988618379;

// What a pixel has, in arrays over the window's pixels.
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer FloatImage { float at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Vec2Image { vec2 at[]; };
layout(buffer_reference, scalar, buffer_reference_align = 4) buffer Vec3Image { vec3 at[]; };

/// Number of a pixel of the window in such arrays.
uint pixel_index(uvec2 at)
{
    return at.y * frame.c.size.x + at.x;
}

/// The pixel of that number.
uvec2 pixel_place(uint pixel)
{
    return uvec2(pixel % frame.c.size.x, pixel / frame.c.size.x);
}

/// First thing in main of a kernel with an invocation per pixel: sets `frame` and finds the pixel; false: there is none.
bool begin_pixel(Address constants, out uvec2 at, out uint pixel)
{
    frame = FrameRef(constants);
    at = gl_GlobalInvocationID.xy;
    pixel = pixel_index(at);
    return all(lessThan(at, frame.c.size));
}

/// The place in the whole picture of a pixel of the window.
uvec2 picture_pixel(uvec2 at)
{
    return frame.c.corner + at;
}

/// Rec.709 luminance.
float luminance(vec3 rgb)
{
    return dot(rgb, vec3(0.2126, 0.7152, 0.0722));
}

#endif
